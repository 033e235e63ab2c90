//! Colours for a light background that colour-blind people can also distinguish (Okabe and Ito).

use plotters::style::RGBColor;
use tertius_core::alarm::Level;

pub const INK: RGBColor = RGBColor(34, 34, 34);
pub const GREY: RGBColor = RGBColor(110, 110, 110);
pub const PALE: RGBColor = RGBColor(176, 190, 204);
pub const BLUE: RGBColor = RGBColor(0, 91, 158);
pub const SKY: RGBColor = RGBColor(86, 160, 211);
pub const VERMILION: RGBColor = RGBColor(196, 78, 0);
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub const GREEN: RGBColor = RGBColor(0, 128, 96);
pub const PURPLE: RGBColor = RGBColor(176, 84, 140);
pub const RED: RGBColor = RGBColor(200, 16, 46);

/// Colour of the threshold that raises.
pub const HIGH: RGBColor = RED;
/// Colour of the threshold that clears.
pub const LOW: RGBColor = ORANGE;

/// Colours of cylinders 1 to 6.
pub const CYLINDERS: [RGBColor; 6] = [BLUE, VERMILION, GREEN, PURPLE, SKY, INK];

/// The colour of the cylinder `number` (from 1).
pub const fn cylinder(number: usize) -> RGBColor {
    CYLINDERS[(number + CYLINDERS.len() - 1) % CYLINDERS.len()]
}

/// Colour of an alarm level.
pub const fn level(level: Level) -> RGBColor {
    match level {
        Level::None => GREY,
        Level::Yellow => RGBColor(222, 178, 0),
        Level::Orange => RGBColor(236, 112, 0),
        Level::Red => RED,
        Level::Black => RGBColor(0, 0, 0),
    }
}
