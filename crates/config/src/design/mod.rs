//! From settings and a DBC to everything that a monitor is made from.

mod connector;
mod devices;
mod estimate;
mod flaw;
mod process;
mod scale;
mod sequential;
mod state;
mod surveyed;
mod tilt;
mod times;

pub use estimate::accommodation;
pub use flaw::Flaw;
pub use sequential::sequential;

use super::settings::Settings;
use super::text::bus_of;
use connector::{Connected, Connector};
use flaw::once_per_key;
use process::deadlines;
use tertius_core::compare::Comparator;
use tertius_core::frame::BusNumber;
use tertius_core::monitor::cylinder::{CylinderDesign, LastParameters, ReckoningParameters};
use tertius_core::monitor::gate::Gate;
use tertius_core::monitor::subscriptions::{Subscription, Target};
use tertius_core::monitor::{Estimates, MonitorDesign};
use tertius_core::observe::commands::LearntCommands;
use tertius_core::observe::model::Model;
use tertius_core::observe::observer::ObserverDesign;
use tertius_core::sample::cycle::CycleTiming;
use tertius_core::sample::plausibility::PlausibilityLimits;
use tertius_core::sample::{Field, Transducer};
use tertius_core::time::Span;
use tertius_core::verdict::fault::Signatures;
use tertius_core::verdict::{self, BankDesign, Thresholds};
use tertius_dbc::Database;

/// The monitor for `settings`, with the signals of `database`.
///
/// # Errors
/// The first flaw of each key: signals that the DBC does not have or that cannot be used, identifiers
/// that are the gateway's own or of two inputs, states without a number, weights without an observer gain, models
/// and tables of another sample time, estimates that do not fit Fd_Estimate.
pub fn judging(settings: &Settings, database: &Database) -> Result<MonitorDesign, Vec<Flaw>> {
    let mut connector = Connector::new(settings, database, false);
    connector.refuse_other_times(true);
    connector.build()
}

/// As [`judging`], for a configuration that is looked at before the machine is commissioned: it may lack a model of its
/// own, also where the default one is of another sample time.
///
/// # Errors
/// See [`judging`], except for the default model.
pub fn checking(settings: &Settings, database: &Database) -> Result<MonitorDesign, Vec<Flaw>> {
    let mut connector = Connector::new(settings, database, false);
    connector.refuse_other_times(false);
    connector.build()
}

/// The monitor for `settings`, whatever sample time its model and tables were made for: for callers
/// that need the signals and judge nothing.
///
/// # Errors
/// See [`judging`], except for sample times.
pub fn unjudging(settings: &Settings, database: &Database) -> Result<MonitorDesign, Vec<Flaw>> {
    Connector::new(settings, database, false).build()
}

/// The monitor for `settings` that also reads the cylinders' pressures, for callers that learn from
/// a recording. The monitor waits for the pressures until the deadline of a cycle, and never
/// reports them missing.
///
/// # Errors
/// See [`unjudging`]; also pressures that are not in bar.
pub fn surveying(settings: &Settings, database: &Database) -> Result<MonitorDesign, Vec<Flaw>> {
    Connector::new(settings, database, true).build()
}

impl Connector<'_> {
    fn build(mut self) -> Result<MonitorDesign, Vec<Flaw>> {
        let settings = self.settings;
        self.connect_sync();
        let (monitored, stops) = self.connect_state();
        let cylinders = (1..=settings.machine.cylinders)
            .filter_map(|n| self.connect_cylinder(n))
            .collect::<Vec<_>>();
        let (tilt, supply) = (self.connect_tilt(), self.supply());
        self.connect_devices();
        self.refuse_own_identifiers();
        self.refuse_crowded_cycles();
        match self.encoder() {
            Some(encoder) if self.flaws.is_empty() => Ok(MonitorDesign {
                subscriptions: self.subscriptions,
                timing: CycleTiming {
                    sample_time: Span::from_seconds(settings.machine.sample_time),
                    deadline: Span::from_seconds(settings.cycle_deadline()),
                    synchronised: settings.signals.sync.is_some(),
                },
                gap_cycles: settings.cycles(settings.machine.max_gap).into(),
                gate: Gate::new(
                    monitored,
                    stops,
                    Span::from_seconds(settings.plausibility.state_stale),
                ),
                cylinders,
                tilt,
                supply,
                estimates: if settings.estimate.send { Estimates::Sent } else { Estimates::None },
                encoder,
            }),
            _ => Err(once_per_key(self.flaws)),
        }
    }

    fn connect_sync(&mut self) {
        let Some(name) = &self.settings.signals.sync else { return };
        let (bus, name) = bus_of(name).unwrap_or((BusNumber::First, name));
        match self.database.message(name) {
            Ok(message) => self.subscriptions.subscribe(bus, message.id).sync = true,
            Err(error) => self.flaws.push(Flaw::new(
                "signals.sync",
                error,
                "name the message that opens a cycle, or leave the key out",
            )),
        }
    }

    fn connect_cylinder(&mut self, n: u8) -> Option<CylinderDesign> {
        let before = self.flaws.len();
        let signals = &self.settings.signals.cylinder;
        let second = signals.c2.as_deref().filter(|_| self.settings.has_c2(n));
        let limits = [
            self.connect_transducer(n, Transducer::C1, Some(&signals.c1)),
            self.connect_transducer(n, Transducer::C2, second),
        ];
        self.connect(n, "control_speed", Some(&signals.control_speed), Field::Command);
        let required = self.connected(n);
        self.connect_surveyed(n, signals);
        let observers = self.observers(n);
        let sequential = self.sequential(n);
        let process = self.process(n);
        let ([first, second], Some(observers)) = (limits, observers) else { return None };
        if self.flaws.len() > before {
            return None;
        }
        let settings = self.settings;
        let (gain, offset) = settings.comparator_of(n);
        let clear = Span::from_seconds(settings.alarm.clear);
        let (fde, judged) = (&settings.fde, &verdict::VerdictParameters::DEFAULT);
        let thresholds = |low, high| Thresholds { low, high, clear };
        Some(CylinderDesign {
            number: n,
            required,
            awaited: self.connected(n),
            buses: self.buses(n),
            devices: self.watched(n),
            command_offset: settings.command_offset_of(n),
            command_stale: settings.cycles(settings.plausibility.stale).max(1),
            commands: LearntCommands {
                size: fde.command.unwrap_or(f64::INFINITY),
                change: fde.command_change.unwrap_or(f64::INFINITY),
            },
            moving_speed: settings.plausibility.frozen_speed,
            comparator: Comparator { gain, offset },
            observes: fde.enabled,
            compares: settings.comparator.enabled,
            bank: BankDesign {
                observer: thresholds(fde.low, fde.high),
                joint: fde.joint.unwrap_or(f64::INFINITY),
                difference: thresholds(settings.comparator_low(), settings.comparator.bound),
                lasting: judged.lasting_of(sequential.is_some() || fde.is_learnt()),
                calibrated: settings.is_aligned(n),
                signatures: observers.each_ref().map(Signatures::of_innovation),
                parameters: judged,
                sample_time: settings.machine.sample_time,
            },
            last: &LastParameters::DEFAULT,
            reckoning: &ReckoningParameters::DEFAULT,
            observers,
            estimate: self.estimate(n, sequential.as_ref(), first.lengths),
            sequential,
            process,
            limits: [first, second],
            critical: settings.comparator.critical,
            levels: settings.alarm.levels.clone(),
            deadlines: deadlines(settings),
            coincidence: Span::from_seconds(settings.alarm.coincidence),
            coincidence_cycles: settings.cycles(settings.alarm.coincidence),
            clear,
        })
    }

    /// Buses of C1, C2 and the command of cylinder `n`; what is not connected is on none that matters.
    fn buses(&self, n: u8) -> [BusNumber; 3] {
        let fields =
            [Field::Position(Transducer::C1), Field::Position(Transducer::C2), Field::Command];
        fields.map(|field| {
            let target = Target::Cylinder(n - 1, field);
            let has = |it: &&Subscription| it.signals.iter().any(|signal| signal.target == target);
            self.subscriptions.all().iter().find(has).map_or(BusNumber::First, |it| it.bus)
        })
    }

    /// The fields of cylinder `n` that were connected, by [`Field::bit`].
    fn connected(&self, n: u8) -> u16 {
        let signals =
            self.subscriptions.all().iter().flat_map(|subscription| &subscription.signals);
        let bits = signals.filter_map(|one| match one.target {
            Target::Cylinder(index, field) if index + 1 == n => Some(field.bit()),
            _ => None,
        });
        bits.fold(0, |all, bit| all | bit)
    }

    fn connect_transducer(
        &mut self,
        n: u8,
        which: Transducer,
        name: Option<&str>,
    ) -> PlausibilityLimits {
        let signals = &self.settings.signals.cylinder;
        let (prefix, velocity, status, counter) = match which {
            Transducer::C1 => ("c1", &signals.c1_velocity, &signals.c1_status, &signals.c1_counter),
            Transducer::C2 => ("c2", &signals.c2_velocity, &signals.c2_status, &signals.c2_counter),
        };
        let position = self.connect(n, prefix, name, Field::Position(which));
        if name.is_some() {
            let key = |suffix| format!("{prefix}_{suffix}");
            self.connect(n, &key("velocity"), velocity.as_deref(), Field::Velocity(which));
            self.connect(n, &key("status"), status.as_deref(), Field::Status(which));
            self.connect(n, &key("counter"), counter.as_deref(), Field::Counter(which));
        }
        self.limits(position)
    }

    fn limits(&self, position: Option<Connected<'_>>) -> PlausibilityLimits {
        let plausibility = &self.settings.plausibility;
        let signal = position.map(|Connected { signal, .. }| signal);
        let [lowest, highest] =
            signal.map_or(self.settings.machine.stroke, |it| self.settings.valid_lengths(it));
        let counts = signal.filter(|signal| !signal.plan.is_float());
        let half_count = counts.map_or(0.0, |signal| signal.plan.factor().abs() / 2.0);
        // Half of the way of the slowest command that counts as moving, so that a stroke which just
        // begins is not taken for one that stands still; yet where commands are in another unit it is
        // no length, and healthy readings are never apart by more than the bound of R3.
        let way = 0.5 * plausibility.frozen_speed * plausibility.frozen;
        PlausibilityLimits {
            stale: self.settings.cycles(plausibility.stale).max(1),
            broken_wire_codes: signal.map_or(Vec::new(), |it| self.settings.broken_wire_codes(it)),
            status_mask: plausibility.status_mask,
            codes: plausibility.valid_raw.map(|[lowest, highest]| (lowest, highest)),
            // A limit in decimals lies beside its count by rounding.
            lengths: (lowest - half_count, highest + half_count),
            frozen: self.settings.cycles(plausibility.frozen).max(1),
            travel: way.min(self.settings.comparator.bound),
            // A rod that was pushed against its stop left it 15 mm of command later. A slowest command of nearly nothing
            // must not make a rod at rest frozen.
            driven: (30.0 * way).max(20.0 * self.settings.comparator.bound),
        }
    }

    fn observers(&mut self, n: u8) -> Option<[ObserverDesign; 2]> {
        let settings = self.settings;
        let (theta, gamma) = settings.model_of(n);
        let model = Model::new(settings.machine.sample_time, theta, gamma);
        let signals = &settings.signals.cylinder;
        let velocities = [&signals.c1_velocity, &signals.c2_velocity].map(Option::is_some);
        let [first, second] = velocities.map(|velocity| {
            let design = ObserverDesign::new(
                &model,
                settings.observer.q,
                settings.observer.r,
                velocity,
                settings.cycles(settings.observer.settle),
                settings.cycles(settings.machine.max_gap),
            );
            design.map_err(|error| {
                self.flaws.push(Flaw::new(
                    "observer.q",
                    format!("cylinder {n} has no observer gain: {error}"),
                    "check theta and gamma of the model, and the weights q and r",
                ));
            })
        });
        Some([first.ok()?, second.ok()?])
    }

    fn refuse_own_identifiers(&mut self) {
        let own = self.settings.own_identifiers();
        for subscription in self
            .subscriptions
            .all()
            .iter()
            .filter(|it| it.bus == BusNumber::First && own.contains(&it.id))
        {
            self.flaws.push(Flaw::new(
                "gateway.node",
                format!("identifier 0x{} is the gateway's own and also an input", subscription.id),
                "choose a node whose identifiers nothing else on the bus sends",
            ));
        }
    }
}
