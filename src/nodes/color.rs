//! Colours: their models, and the nodes that change one of them.

use super::math::power;
use glam::Vec3;

choice! {
    /// In which numbers Combine Color and Separate Color count.
    ColorModel {
        /// Red, green, blue.
        Rgb = "RGB",
        /// Hue, saturation, value.
        Hsv = "HSV",
        /// Hue, saturation, lightness.
        Hsl = "HSL",
    }
}

/// The hue of a colour, by its greatest and least numbers; 0 where it is grey.
fn hue(c: Vec3, most: f32, least: f32) -> f32 {
    let range = most - least;
    if range == 0.0 {
        return 0.0;
    }
    let to = (Vec3::splat(most) - c) / range;
    let sixths = if c.x == most {
        to.z - to.y
    } else if c.y == most {
        2.0 + to.x - to.z
    } else {
        4.0 + to.y - to.x
    };
    let hue = sixths * (1.0 / 6.0);
    if hue < 0.0 { hue + 1.0 } else { hue }
}

/// A colour of full value and saturation.
fn pure(hue: f32) -> Vec3 {
    let ramp = |shift: f32| ((hue * 6.0 - shift).abs() - 1.0).clamp(0.0, 1.0);
    Vec3::new(ramp(3.0), 1.0 - ramp(2.0), 1.0 - ramp(4.0))
}

/// Hue, saturation and value.
pub fn to_hsv(c: Vec3) -> Vec3 {
    let (most, least) = (c.max_element(), c.min_element());
    let saturation = if most == 0.0 {
        0.0
    } else {
        (most - least) / most
    };
    let hue = if saturation == 0.0 {
        0.0
    } else {
        hue(c, most, least)
    };
    Vec3::new(hue, saturation, most)
}

/// From hue, saturation and value.
pub fn from_hsv(c: Vec3) -> Vec3 {
    if c.y == 0.0 {
        return Vec3::splat(c.z);
    }
    let hue = if c.x == 1.0 { 0.0 } else { c.x };
    if !(0.0..1.0).contains(&hue) {
        // Cycles counts what lies beyond the circle to its last sixth, with its own place between two sixths.
        let sixths = hue * 6.0;
        let along = sixths - sixths.floor();
        return Vec3::new(c.z, c.z * (1.0 - c.y), c.z * (1.0 - c.y * along));
    }
    (Vec3::ONE + (pure(hue) - 1.0) * c.y) * c.z
}

/// Hue, saturation and lightness.
fn to_hsl(c: Vec3) -> Vec3 {
    let (most, least) = (c.max_element(), c.min_element());
    let lightness = ((most + least) / 2.0).min(1.0);
    if most == least {
        return Vec3::new(0.0, 0.0, lightness);
    }
    let range = most - least;
    let saturation = if lightness > 0.5 {
        range / (2.0 - most - least)
    } else {
        range / (most + least)
    };
    Vec3::new(hue(c, most, least), saturation, lightness)
}

/// From hue, saturation and lightness.
fn from_hsl(c: Vec3) -> Vec3 {
    let chroma = (1.0 - (2.0 * c.z - 1.0).abs()) * c.y;
    (pure(c.x) - 0.5) * chroma + c.z
}

impl ColorModel {
    /// Its numbers of a colour.
    pub fn separate(self, c: Vec3) -> Vec3 {
        match self {
            Self::Rgb => c,
            Self::Hsv => to_hsv(c),
            Self::Hsl => to_hsl(c),
        }
    }

    /// The colour of its numbers.
    pub fn combine(self, c: Vec3) -> Vec3 {
        match self {
            Self::Rgb => c,
            Self::Hsv => from_hsv(c),
            Self::Hsl => from_hsl(c),
        }
    }
}

/// Hue/Saturation/Value: 0.5, 1 and 1 change nothing.
#[inline]
pub fn hue_saturation(hue: f32, saturation: f32, value: f32, factor: f32, c: Vec3) -> Vec3 {
    let mut hsv = to_hsv(c);
    hsv.x += hue + 0.5;
    hsv.x -= hsv.x.floor();
    hsv.y = (hsv.y * saturation).clamp(0.0, 1.0);
    hsv.z *= value;
    (from_hsv(hsv) * factor + c * (1.0 - factor)).max(Vec3::ZERO)
}

/// Brightness/Contrast.
pub fn bright_contrast(c: Vec3, bright: f32, contrast: f32) -> Vec3 {
    (c * (1.0 + contrast) + (bright - contrast * 0.5)).max(Vec3::ZERO)
}

/// Gamma: numbers that are not positive stay.
pub fn gamma(c: Vec3, gamma: f32) -> Vec3 {
    let of = |v: f32| if v > 0.0 { power(v, gamma) } else { v };
    if gamma == 0.0 {
        return Vec3::ONE;
    }
    Vec3::new(of(c.x), of(c.y), of(c.z))
}

/// Invert Color.
pub fn invert(factor: f32, c: Vec3) -> Vec3 {
    (1.0 - c) * factor + c * (1.0 - factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_go_there_and_back() {
        for c in [
            [0.2, 0.5, 0.9],
            [0.7, 0.1, 0.4],
            [0.3, 0.3, 0.3],
            [0.9, 0.8, 0.0],
        ] {
            let c = Vec3::from(c);
            for model in [ColorModel::Rgb, ColorModel::Hsv, ColorModel::Hsl] {
                let back = model.combine(model.separate(c));
                assert!(
                    (back - c).abs().max_element() < 1e-6,
                    "{model:?} {c} {back}"
                );
            }
        }
        assert_eq!(
            to_hsv(Vec3::new(0.0, 0.5, 0.0)),
            Vec3::new(1.0 / 3.0, 1.0, 0.5)
        );
        assert_eq!(ColorModel::Hsl.separate(Vec3::new(0.0, 0.5, 0.0)).z, 0.25);
        // As Cycles 5.2 has it of hues beyond the circle.
        let beyond = from_hsv(Vec3::new(-0.25, 0.5, 0.8));
        assert!(
            (beyond - Vec3::new(0.8, 0.4, 0.6)).length() < 1e-6,
            "{beyond}"
        );
    }

    #[test]
    fn colours_change_as_in_blender() {
        let c = Vec3::new(0.8, 0.4, 0.2);
        assert!((hue_saturation(0.5, 1.0, 1.0, 1.0, c) - c).length() < 1e-6);
        assert!((hue_saturation(0.5, 0.0, 1.0, 1.0, c) - Vec3::splat(0.8)).length() < 1e-6);
        assert_eq!(bright_contrast(c, -1.0, 0.0), Vec3::ZERO);
        assert_eq!(
            gamma(Vec3::new(-1.0, 0.25, 0.0), 0.5),
            Vec3::new(-1.0, 0.5, 0.0)
        );
        assert_eq!(invert(0.5, c), Vec3::splat(0.5));
    }
}
