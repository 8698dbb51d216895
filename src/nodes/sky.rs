//! Blender's Sky Texture: a table of the model's radiance, and the disc of the sun as Cycles draws it.
//!
//! The table is what the model gives at the middles of its texels (the add-on asks Blender for them), in the mapping by which
//! Cycles 5 reads its own: rows stand closer toward the horizon.

use glam::Vec3;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, TAU};

/// The radiance of a sky by direction.
#[derive(Clone, PartialEq)]
pub struct Sky {
    /// Texels a row: once around.
    pub width: usize,
    /// Rows: from the zenith down to the nadir.
    pub height: usize,
    /// The upper row first.
    pub texels: Vec<Vec3>,
    /// Where rows begin: minus the azimuth, radians.
    pub start: f32,
    /// The sun, if it is drawn.
    pub sun: Option<SunDisc>,
    /// Where light sampling looks for a sun that the sky does not show: Cycles does so in skies of the older models.
    pub sought: Option<SunCone>,
}

/// The directions of a sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunCone {
    /// Toward its middle, unit length.
    pub direction: Vec3,
    /// Its angular radius.
    pub half_angle: f32,
}

/// The disc of the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDisc {
    /// Toward its middle, unit length.
    pub direction: Vec3,
    /// Its angular radius.
    pub half_angle: f32,
    /// Two elevations.
    pub elevations: [f32; 2],
    /// The radiance at these before limb darkening; between them and beyond it is linear.
    pub colors: [Vec3; 2],
    /// Below this elevation it is hidden.
    pub horizon: f32,
    /// Whether it stands before the sky, as in Cycles before version 5, or its light is added.
    pub covers: bool,
}

impl SunDisc {
    /// The angle to its middle: by a way that does not cancel, and that is Cycles' where the direction is not of unit length.
    fn angle(&self, d: Vec3) -> f32 {
        let (chord, other) = (d - self.direction, d + self.direction);
        2.0 * chord.length().atan2(other.length())
    }

    /// Its radiance in a direction, if it is seen there. Colours that the space lacks are below 0.
    fn of(&self, d: Vec3, elevation: f32) -> Option<Vec3> {
        let from_middle = self.angle(d) / self.half_angle;
        if from_middle >= 1.0 || elevation <= self.horizon {
            return None;
        }
        let [low, high] = self.elevations;
        let y = (elevation - low) / (high - low);
        let [bottom, top] = self.colors;
        // Cycles' limb darkening, of coefficient 0.6.
        let darkening = 1.0 - 0.6 * (1.0 - (1.0 - from_middle * from_middle).sqrt());
        Some(bottom.lerp(top, y) * darkening)
    }
}

impl Sky {
    /// The radiance from a direction.
    pub fn of(&self, direction: Vec3) -> Vec3 {
        // Directions from worlds are of unit length; of others Cycles takes the coordinates as they are.
        let d = direction;
        let elevation = FRAC_PI_2 - d.z.clamp(-1.0, 1.0).acos();
        let azimuth = d.y.atan2(d.x);
        let x = (-(azimuth + self.start) / TAU).rem_euclid(1.0);
        // More rows toward the horizon.
        let y = (elevation.abs() * FRAC_2_PI).sqrt().copysign(elevation) * 0.5 + 0.5;
        let sky = self.at(x, 1.0 - y);
        let Some(sun) = &self.sun else {
            return sky;
        };
        match sun.of(d, elevation) {
            None => sky,
            Some(light) if sun.covers => light.max(Vec3::ZERO),
            Some(light) => (sky + light).max(Vec3::ZERO),
        }
    }

    /// Bilinear between the middles of texels; it ends at the edges, as Cycles' own table.
    fn at(&self, x: f32, y: f32) -> Vec3 {
        let (columns, rows) = (self.width, self.height);
        let place = |v: f32, n: usize| {
            let v = (v * n as f32 - 0.5).clamp(0.0, (n - 1) as f32);
            let first = (v as usize).min(n - 1);
            (first, (first + 1).min(n - 1), v - first as f32)
        };
        let ((x0, x1, s), (y0, y1, t)) = (place(x, columns), place(y, rows));
        let texel = |x: usize, y: usize| self.texels[y * columns + x];
        let upper = texel(x0, y0).lerp(texel(x1, y0), s);
        let lower = texel(x0, y1).lerp(texel(x1, y1), s);
        upper.lerp(lower, t)
    }
}

impl std::fmt::Debug for Sky {
    /// The texels as a hash: of scenes all is written down to tell them apart.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // FNV-1a.
        let mut hash = 0xcbf2_9ce4_8422_2325u64;
        for v in self.texels.iter().flat_map(|t| t.to_array()) {
            hash = (hash ^ u64::from(v.to_bits())).wrapping_mul(0x0100_0000_01b3);
        }
        f.debug_struct("Sky")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("texels", &format_args!("{hash:016x}"))
            .field("start", &self.start)
            .field("sun", &self.sun)
            .field("sought", &self.sought)
            .finish()
    }
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/sky.rs"]
mod tests;
