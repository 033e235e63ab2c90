//! A chart of columns against a limit.

use super::marks::{Marks, beyond, quiet};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Values of `columns` equal parts of the `length` (s) before the newest bin, the largest of each part; bins are
/// (begin, value) in the order of time.
pub fn columns(
    bins: impl DoubleEndedIterator<Item = (f64, Option<f64>)>,
    length: f64,
    columns: usize,
) -> Vec<Option<f64>> {
    let mut values = vec![None; columns];
    let mut newest = None;
    for (time, value) in bins.rev() {
        let before = *newest.get_or_insert(time) - time;
        let back = (before / length * columns as f64) as usize;
        let Some(place) = columns.checked_sub(back + 1) else { break };
        values[place] = [values[place], value].into_iter().flatten().reduce(f64::max);
    }
    values
}

/// The value at the top of a chart, and its limit; both in the unit of the values.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    top: f64,
    limit: Option<f64>,
}

impl Scale {
    /// A scale on which the limit is always to be seen, and every value.
    pub fn new(columns: &[Option<f64>], limit: Option<f64>) -> Self {
        let largest = columns.iter().flatten().copied().fold(0.0, f64::max);
        let top = limit.map_or(largest, |limit| largest.max(1.25 * limit));
        Self { top: if top > 0.0 { top } else { 1.0 }, limit }
    }
}

pub struct Chart<'a> {
    pub columns: &'a [Option<f64>],
    pub scale: Scale,
    pub marks: Marks,
}

impl Chart<'_> {
    /// Draws columns from the bottom, the limit as a line behind them, and a dot where nothing was judged.
    pub fn draw(&self, area: Rect, buffer: &mut Buffer) {
        let height = usize::from(area.height);
        let eighths = |value: f64| (value / self.scale.top * 8.0 * height as f64).round() as usize;
        let limit =
            self.scale.limit.map(|limit| (eighths(limit) / 8).min(height.saturating_sub(1)));
        for (x, value) in (area.x..area.right()).zip(self.columns) {
            let filled = value.map_or(0, |value| eighths(value).max(1));
            let crosses = value.zip(self.scale.limit).is_some_and(|(value, limit)| value > limit);
            for row in 0..height {
                let part = filled.saturating_sub(8 * row);
                let (sign, style) = match part {
                    0 if limit == Some(row) => (self.marks.pick("╌", "-"), quiet()),
                    0 if row == 0 => (self.marks.pick("·", "."), quiet()),
                    0 => continue,
                    part => {
                        (self.marks.column(part), if crosses { beyond() } else { Style::new() })
                    }
                };
                let y = area.bottom() - 1 - row as u16;
                buffer.set_stringn(x, y, sign, 1, style);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_is_at_the_right_and_the_largest_of_each_part_stays() {
        let bins = [(0.0, Some(9.0)), (10.0, Some(1.0)), (19.0, Some(3.0)), (20.0, Some(2.0))];
        assert_eq!(columns(bins.into_iter(), 20.0, 4), [None, Some(1.0), None, Some(3.0)]);
        assert_eq!(columns(bins.into_iter(), 20.0, 0), []);
        assert_eq!(columns([].into_iter(), 20.0, 2), [None; 2]);
    }

    #[test]
    fn a_limit_is_always_to_be_seen() {
        let area = Rect::new(0, 0, 3, 4);
        for (values, above) in [([Some(0.1); 3], false), ([Some(8.0); 3], true)] {
            let mut buffer = Buffer::empty(area);
            let marks = Marks { unicode: true, colours: true };
            let scale = Scale::new(&values, Some(1.0));
            Chart { columns: &values, scale, marks }.draw(area, &mut buffer);
            let cells: Vec<&str> = buffer.content.iter().map(|cell| cell.symbol()).collect();
            assert_eq!(cells.contains(&"╌"), !above, "{cells:?}");
            assert_eq!(cells[0] == "█", above, "{cells:?}");
        }
    }
}
