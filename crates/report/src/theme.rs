//! Colours, shared by plots, picture and page. Hues after Okabe and Ito, told apart with every kind of colour vision.
//!
//! The page's style sheet gives each of them a counterpart for dark screens; a test keeps both lists equal.

use plotters::style::RGBColor;

use crate::Rung;

/// What a colour stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Ink,
    Faint,
    Grid,
    Blue,
    Orange,
    Green,
    Red,
    Purple,
    Grey,
    Paper,
}

impl Role {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 10] = [
        Self::Ink,
        Self::Faint,
        Self::Grid,
        Self::Blue,
        Self::Orange,
        Self::Green,
        Self::Red,
        Self::Purple,
        Self::Grey,
        Self::Paper,
    ];

    /// Red, green and blue.
    const fn rgb(self) -> (u8, u8, u8) {
        match self {
            Self::Ink => (0x1F, 0x29, 0x33),
            Self::Faint => (0x61, 0x6E, 0x7C),
            Self::Grid => (0xE4, 0xE7, 0xEB),
            Self::Blue => (0x00, 0x72, 0xB2),
            Self::Orange => (0xE6, 0x9F, 0x00),
            Self::Green => (0x00, 0x9E, 0x73),
            Self::Red => (0xD5, 0x5E, 0x00),
            Self::Purple => (0xA6, 0x4D, 0x8C),
            Self::Grey => (0x8D, 0x95, 0x9E),
            Self::Paper => (0xFB, 0xFC, 0xFD),
        }
    }

    /// For plotters.
    pub(crate) const fn color(self) -> RGBColor {
        let (red, green, blue) = self.rgb();
        RGBColor(red, green, blue)
    }

    /// For SVG and CSS, as plotters writes it.
    pub(crate) fn hex(self) -> String {
        let (red, green, blue) = self.rgb();
        format!("#{red:02X}{green:02X}{blue:02X}")
    }

    /// Name of the colour in the style sheet, without the leading dashes.
    pub(crate) const fn css(self) -> &'static str {
        match self {
            Self::Ink => "ink",
            Self::Faint => "faint",
            Self::Grid => "grid",
            Self::Blue => "blue",
            Self::Orange => "orange",
            Self::Green => "green",
            Self::Red => "red",
            Self::Purple => "purple",
            Self::Grey => "grey",
            Self::Paper => "paper",
        }
    }
}

/// Colour of a rung of the ladder.
pub(crate) const fn rung_role(rung: Rung) -> Role {
    match rung {
        Rung::Filtered => Role::Green,
        Rung::Relaxed => Role::Orange,
        Rung::Braking => Role::Red,
        Rung::Stopped => Role::Purple,
        Rung::Silent => Role::Ink,
    }
}
