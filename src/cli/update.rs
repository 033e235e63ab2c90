//! `--update`: learns from a recording together with what is kept of earlier ones.

use super::Failure;
use super::files::{Inputs, Mark, Overwriting};
use super::learnt_file::{LearntFile, Prepared};
use super::survey::{Surveyed, placed};
use crate::calibrate::Cuts;
use crate::failure::print;
use crate::frame::Frame;
use crate::learnt::thinning::Visiting;
use crate::learnt::{
    Clash, Damage, Judging, Learnt, MOST_BYTES, Packing, Part, Parting, Piece, Seals,
};
use crate::monitor::Counts;
use crate::survey::{Frames, Origin, Recording, Rows, Surveyor, Timeline, Window};
use crate::text::counted;
use std::path::Path;

/// How a recording is added to what is kept.
#[derive(Clone, Copy, Debug)]
pub struct Update {
    /// Whether what is kept is discarded.
    pub fresh: bool,
    /// Whether all tables are learnt again, and not only those of a calibration.
    pub all: bool,
}

/// Data to learn from: a recording alone, or with what is kept of earlier ones.
pub struct Study {
    pub surveyed: Surveyed,
    timeline: Timeline,
    pub window: Window,
    /// Parts that the present tables do not take for healthy.
    pub cuts: Cuts,
    keeping: Option<Keeping>,
}

/// What is kept, and what is new.
struct Keeping {
    file: LearntFile,
    earlier: Learnt,
    /// Parts of the recording that are new.
    novel: Vec<Part>,
}

impl Study {
    /// A study of a recording alone.
    pub fn alone(surveyed: Surveyed) -> Self {
        let (timeline, window) = (surveyed.timeline.clone(), surveyed.window);
        Self { surveyed, timeline, window, cuts: Cuts::default(), keeping: None }
    }

    /// A study of a recording that is added to what is kept beside `config`; `None` where it is
    /// already included, which is reported.
    ///
    /// # Errors
    /// What is kept belongs to other tables; the recording is partly known, or not healthy
    /// by the present tables.
    pub fn adding(
        surveyed: Surveyed,
        config: &Path,
        update: Update,
    ) -> Result<Option<Self>, Failure> {
        let loaded = &surveyed.machine.loaded;
        let machine = loaded.settings.machine.name.clone();
        let file = LearntFile::beside(config);
        let inputs = Inputs::new(surveyed.logs().chain(surveyed.machine.files(config)));
        inputs.claim([(Some(file.path()), Mark::Judged)], Overwriting::default())?;
        let seals = seals(loaded.document.effective(), &loaded.layout())?;
        let earlier = if update.fresh {
            file.is_ours()?;
            None
        } else {
            file.read(&seals, update.all)?
        };
        let earlier = earlier.unwrap_or(Learnt { machine, ..Learnt::default() });
        let novel = novel(&surveyed, &earlier)?;
        if novel.is_empty() {
            print(&format!(
                "{} was already learnt: it is in {}, and nothing changes\n",
                surveyed.inputs(),
                file.path().display()
            ))?;
            return Ok(None);
        }
        let mut study = Self::alone(surveyed);
        let keeping = Keeping { file, earlier, novel };
        if !keeping.earlier.pieces.is_empty() {
            study.join(&keeping)?;
        }
        study.keeping = Some(keeping);
        Ok(Some(study))
    }

    /// Judges the recording by the present tables, and adds it to the pieces that are kept.
    fn join(&mut self, keeping: &Keeping) -> Result<(), Failure> {
        let surveyed = &self.surveyed;
        let mut judging = Judging::new(&surveyed.machine.loaded.settings, &surveyed.design);
        surveyed.read(surveyed.window, &mut judging)?;
        let judgement = judging.judgement(surveyed.window);
        if !judgement.refused.is_empty() {
            return Err(Failure::Failed(format!(
                "by the tables of the earlier recordings, the machine in {} is not healthy; \
                 nothing was learnt from it, and nothing was written:\n  {}\nRepair it and record \
                again, or leave that part out (--from, --to); if the machine has changed, start \
                again (--update --fresh)",
                surveyed.inputs(),
                judgement.refused.join("\n  ")
            )));
        }
        let told: String = judgement.left_out.iter().map(|line| format!("{line}\n")).collect();
        print(&told)?;
        let mut timeline = Timeline::default();
        keeping.merged(
            surveyed,
            |_| true,
            |frame| {
                timeline.take(frame.timestamp);
                if surveyed.reads(frame) {
                    timeline.read(frame);
                }
            },
        )?;
        self.cuts = judgement.cuts.moved(|t| timeline.seconds(surveyed.timeline.at(t)));
        self.window = Window { from: 0.0, to: timeline.length() + 1e-9 };
        self.timeline = timeline;
        Ok(())
    }

    /// Origin of the rows.
    pub fn origin(&self) -> Origin {
        let own = self.surveyed.origin();
        let Some(keeping) = self.keeping.as_ref().filter(|it| !it.earlier.pieces.is_empty()) else {
            return own;
        };
        let parts = keeping.earlier.parts.len();
        let inputs = format!(
            "{}, with what is kept of {} earlier",
            own.inputs,
            counted(parts as u64, "recording")
        );
        let place = |part: &Part| {
            let [from, to] = [part.first, part.last].map(|at| self.timeline.seconds(at));
            format!("{from:.1} to {to:.1} s")
        };
        let places: Vec<String> = keeping.novel.iter().map(place).collect();
        let told = format!(
            "times include all kept recordings, with long pauses as a minute: this recording is at \
             {}",
            places.join(", ")
        );
        let remarks = [told].into_iter().chain(self.surveyed.remarks()).collect();
        Origin { inputs, timeline: self.timeline.clone(), window: self.window, remarks }
    }

    /// Writes what is kept from now on beside its file, for a configuration with the text `after`, the overrides of
    /// this call included where the tables do not replace them; does nothing where nothing is kept. Times that were `left_out` are not kept.
    ///
    /// # Errors
    /// The file cannot be written, or the recording can no longer be read.
    pub fn prepare(&self, after: &str, left_out: &Cuts) -> Result<Option<Prepared>, Failure> {
        let Some(Keeping { file, earlier, novel }) = &self.keeping else { return Ok(None) };
        let cuts = self.cuts.with(left_out);
        let t = |at| self.timeline.seconds(at);
        let mut learnt = earlier.clone();
        learnt.pieces.retain(|piece| !cuts.any(t(piece.first()), t(piece.last())));
        let mut packing = Packing::default();
        self.surveyed.recorded(self.surveyed.window, |frame| {
            if cuts.any(t(frame.timestamp), t(frame.timestamp)) {
                packing.close();
            } else if self.surveyed.reads(frame) && holds(novel, frame) {
                packing.take(frame);
            }
        })?;
        learnt.add(novel.iter().copied(), packing.finish());
        learnt.seals = seals(after, &self.surveyed.machine.loaded.layout())?;
        self.thin(&mut learnt)?;
        file.clone().prepare(&learnt).map(Some)
    }

    /// Drops pieces where there are too many.
    fn thin(&self, learnt: &mut Learnt) -> Result<(), Failure> {
        if learnt.bytes() <= MOST_BYTES {
            return Ok(());
        }
        let mut visiting = Visiting::new(&learnt.pieces, &self.timeline);
        self.read(self.window, &mut visiting)?;
        let bytes: Vec<usize> = learnt.pieces.iter().map(Piece::bytes).collect();
        let kept = visiting.keep(&bytes, MOST_BYTES);
        learnt.pieces = kept.into_iter().map(|index| learnt.pieces[index].clone()).collect();
        Ok(())
    }
}

impl Keeping {
    /// Passes the frames of the pieces that are `wanted` and those that are new in `surveyed` to
    /// `take`, in the order of time and with their original time stamps.
    fn merged(
        &self,
        surveyed: &Surveyed,
        wanted: impl Fn(&Piece) -> bool,
        mut take: impl FnMut(&Frame),
    ) -> Result<(), Failure> {
        let mut waiting = self.earlier.pieces.iter().peekable();
        let mut damage = None;
        let mut unpack = |piece: &Piece, take: &mut dyn FnMut(&Frame)| {
            if wanted(piece) {
                damage = damage.or(piece.unpack(take).err());
            }
        };
        surveyed.recorded(surveyed.window, |frame| {
            while let Some(piece) = waiting.next_if(|piece| piece.first() <= frame.timestamp) {
                unpack(piece, &mut take);
            }
            if holds(&self.novel, frame) {
                take(frame);
            }
        })?;
        waiting.for_each(|piece| unpack(piece, &mut take));
        damage.map_or(Ok(()), |damage: Damage| {
            Err(Failure::Wrong(format!("{}: {damage}", self.file.path().display())))
        })
    }
}

impl Frames for Study {
    type Error = Failure;

    fn frames(&self, window: Window, mut take: impl FnMut(&Frame)) -> Result<(), Failure> {
        let joined = self.keeping.as_ref().filter(|it| !it.earlier.pieces.is_empty());
        let Some(keeping) = joined else {
            return self.surveyed.frames(window, take);
        };
        let t = |at| self.timeline.seconds(at);
        let wanted = |piece: &Piece| t(piece.last()) >= window.from && t(piece.first()) < window.to;
        keeping.merged(&self.surveyed, wanted, |frame| {
            if window.holds(t(frame.timestamp)) {
                placed(frame, &self.timeline, &mut take);
            }
        })
    }
}

impl Recording for Study {
    type Error = Failure;

    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Failure> {
        self.read_counted(window, surveyor).map(drop)
    }

    fn read_counted(&self, window: Window, surveyor: impl Surveyor) -> Result<Counts, Failure> {
        let (design, first) = (&self.surveyed.design, self.timeline.first());
        Rows { frames: self, design, first }.read_counted(window, surveyor)
    }
}

/// Parts of a recording that were not learnt yet.
fn novel(surveyed: &Surveyed, earlier: &Learnt) -> Result<Vec<Part>, Failure> {
    let mut parting = Parting::default();
    surveyed.recorded(surveyed.window, |frame| {
        if surveyed.reads(frame) {
            parting.take(frame);
        }
    })?;
    let mut novel = Vec::new();
    for part in parting.finish() {
        let known = part.is_among(&earlier.parts).map_err(|Clash { part, known }| {
            Failure::Wrong(format!(
                "the recording from {} to {} overlaps with one that was learnt, from {} to {}, but \
                 differs from it: was it cut differently, or was the clock set? Leave out what \
                 is known (--from, --to), or start again (--update --fresh)",
                part.first, part.last, known.first, known.last
            ))
        })?;
        if !known {
            novel.push(part);
        }
    }
    Ok(novel)
}

fn holds(parts: &[Part], frame: &Frame) -> bool {
    parts.iter().any(|part| part.holds(frame.timestamp))
}

fn seals(config: &str, layout: &[u8]) -> Result<Seals, Failure> {
    let none = || Failure::Failed("the configuration cannot be sealed: it is not TOML".to_owned());
    Seals::of(config, layout).ok_or_else(none)
}
