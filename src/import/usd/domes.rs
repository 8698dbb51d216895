//! Images of dome lights in other layouts, and several domes as one.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use crate::scene::{Image, Pixels};

/// How an image covers the directions ("texture:format" of UsdLux' DomeLight).
///
/// In the light's own space the middle of each is +Z and its top +Y, as in an image of latitudes and longitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Layout {
    /// Latitudes and longitudes; its left is +X.
    #[default]
    LatLong,
    /// "An image of the environment reflected in a sphere", seen from +Z without perspective: its right is +X.
    MirroredBall,
    /// The same, but that the distance from the middle grows as the angle does.
    Angular,
    /// The sides of a cube: those about the horizon in the second row, the back below the bottom, upside down.
    VerticalCross,
}

impl Layout {
    pub(super) fn of(word: &str) -> Option<Self> {
        Some(match word {
            // What a file says of itself would come first, but no kind that is read says something.
            "automatic" | "latlong" => Self::LatLong,
            "mirroredBall" => Self::MirroredBall,
            "angular" => Self::Angular,
            "cubeMapVerticalCross" => Self::VerticalCross,
            _ => return None,
        })
    }

    /// Where a direction of the light's space is in the image, from its left and top, 0 to 1; and the part of the image that it
    /// must not be mixed with what is beside: left, top, right, bottom.
    fn place(self, way: DVec3) -> ([f64; 2], [f64; 4]) {
        let whole = [0.0, 0.0, 1.0, 1.0];
        let ball = |radius: f64| {
            let across = glam::DVec2::new(way.x, way.y).length();
            let [x, y] = if across > 0.0 {
                [way.x, way.y].map(|v| v / across * radius)
            } else {
                [radius, 0.0]
            };
            ([0.5 + 0.5 * x, 0.5 - 0.5 * y], whole)
        };
        match self {
            Self::LatLong => (on_map(DVec3::new(way.z, way.x, way.y)), whole),
            // What is seen in the direction r is reflected where the normal is halfway to the viewer.
            Self::MirroredBall => ball((0.5 * (1.0 - way.z)).max(0.0).sqrt()),
            Self::Angular => ball(way.z.clamp(-1.0, 1.0).acos() / PI),
            Self::VerticalCross => cross(way),
        }
    }
}

/// Where a direction is in a vertical cross of 3 by 4 sides.
fn cross(way: DVec3) -> ([f64; 2], [f64; 4]) {
    let most = way.abs().max_element();
    let (column, row, right, down) = if way.z == most {
        (1.0, 1.0, -way.x, -way.y)
    } else if way.y == most {
        (1.0, 0.0, -way.x, way.z)
    } else if way.y == -most {
        (1.0, 2.0, -way.x, -way.z)
    } else if way.z == -most {
        (1.0, 3.0, -way.x, way.y)
    } else if way.x == most {
        (0.0, 1.0, way.z, -way.y)
    } else {
        (2.0, 1.0, -way.z, -way.y)
    };
    let inside = |v: f64| 0.5 + 0.5 * v / most;
    let place = [(column + inside(right)) / 3.0, (row + inside(down)) / 4.0];
    let side = [
        column / 3.0,
        row / 4.0,
        (column + 1.0) / 3.0,
        (row + 1.0) / 4.0,
    ];
    (place, side)
}

/// Where a direction is in an image of latitudes and longitudes whose middle is +X, its left +Y and its top +Z.
fn on_map(way: DVec3) -> [f64; 2] {
    let up = (way.z / way.length()).clamp(-1.0, 1.0).asin();
    let u = 0.5 - way.y.atan2(way.x) / TAU;
    [u.rem_euclid(1.0), 0.5 - up / PI]
}

/// The direction of a place in such an image.
fn way_of([u, v]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (TAU * (0.5 - u)).sin_cos();
    let (up, out) = (PI * (0.5 - v)).sin_cos();
    DVec3::new(out * cos, out * sin, up)
}

/// The colour of an image at a place, from the four texels about it within a part of it; left and right meet where `around`.
fn read(image: &Image, values: &[f32], [u, v]: [f64; 2], part: [f64; 4], around: bool) -> DVec3 {
    let size = [f64::from(image.width), f64::from(image.height)];
    let [left, top, right, bottom] = [0, 1, 2, 3].map(|i| (part[i] * size[i % 2]).round());
    let (x, y) = (u * size[0] - 0.5, v * size[1] - 0.5);
    let texel = |x: f64, y: f64| {
        let x = if around {
            x.rem_euclid(size[0])
        } else {
            x.clamp(left, right - 1.0)
        };
        let y = y.clamp(top, bottom - 1.0);
        let at = 3 * (y as usize * image.width as usize + x as usize);
        let found = values.get(at..at + 3);
        found.map_or(DVec3::ZERO, |c| {
            DVec3::new(c[0].into(), c[1].into(), c[2].into())
        })
    };
    let (x0, y0) = (x.floor(), y.floor());
    let row = |y: f64| texel(x0, y).lerp(texel(x0 + 1.0, y), x - x0);
    row(y0).lerp(row(y0 + 1.0), y - y0)
}

/// Numbers of an image of three channels.
fn numbers(image: &Image) -> Option<&[f32]> {
    match &image.pixels {
        Pixels::F32(values) if image.channels == 3 => Some(&values[..]),
        _ => None,
    }
}

/// An image of latitudes and longitudes, by the colour of each direction.
fn drawn(name: &str, width: u32, color: impl Fn(DVec3) -> DVec3) -> Image {
    let (width, height) = (width.max(2), (width / 2).max(1));
    let mut values = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let [u, v] =
                [(x, width), (y, height)].map(|(at, of)| (f64::from(at) + 0.5) / f64::from(of));
            values.extend(color(way_of([u, v])).as_vec3().to_array());
        }
    }
    Image {
        name: name.into(),
        width,
        height,
        channels: 3,
        pixels: Pixels::from(values),
    }
}

/// The image as one of latitudes and longitudes, with as many texels around the horizon. `None` if it cannot be read so.
pub(super) fn upright(image: &Image, layout: Layout) -> Option<Image> {
    let values = numbers(image)?;
    let around = match layout {
        Layout::VerticalCross => image.width / 3 * 4,
        _ => image.width,
    };
    Some(drawn(&image.name, around, |way| {
        // The middle of a map is +X there and +Z in the light's space.
        let (place, part) = layout.place(DVec3::new(way.y, way.z, way.x));
        read(image, values, place, part, layout == Layout::LatLong)
    }))
}

/// A dome in its place.
pub(super) struct Placed {
    pub image: Option<Image>,
    pub radiance: [f64; 3],
    /// The world to the image's space.
    pub turn: DMat3,
}

/// All domes as one: the sum of their light.
pub(super) fn sum(mut domes: Vec<Placed>) -> Option<Placed> {
    if domes.len() < 2 {
        return domes.pop();
    }
    let widest = |dome: &Placed| dome.image.as_ref().map_or(0, |image| image.width);
    let base = domes.iter().max_by_key(|dome| widest(dome))?;
    let light = |dome: &Placed, way: DVec3| {
        let radiance = DVec3::from(dome.radiance);
        match &dome.image {
            None => radiance,
            Some(image) => {
                let place = on_map(dome.turn * way);
                let values = numbers(image).unwrap_or_default();
                radiance * read(image, values, place, [0.0, 0.0, 1.0, 1.0], true)
            }
        }
    };
    let all = |way: DVec3| domes.iter().map(|dome| light(dome, way)).sum::<DVec3>();
    if widest(base) == 0 {
        return Some(Placed {
            image: None,
            radiance: all(DVec3::X).to_array(),
            turn: DMat3::IDENTITY,
        });
    }
    let (turn, back) = (base.turn, base.turn.transpose());
    let name = base.image.as_ref().map_or("", |image| &image.name);
    Some(Placed {
        image: Some(drawn(name, widest(base), |way| all(back * way))),
        radiance: [1.0; 3],
        turn,
    })
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/domes.rs"]
mod tests;
