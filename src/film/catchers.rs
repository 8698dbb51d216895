//! What a pixel keeps where there are shadow catchers, and the picture that comes of it, as in Cycles.
//!
//! A path of the camera that meets a catcher goes on twice: as ever, and in a scene of the catchers alone. What both find,
//! divided, is what the objects of the scene do to the light on the catcher; light of paths that meet none is the objects' own.

use crate::math::average;
use glam::{DVec3, Vec3};

/// Floats of a pixel.
pub const CATCHER_SUMS: usize = 11;

/// A path as it meets a catcher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// What it weighs there.
    pub throughput: Vec3,
    /// Light that it has gathered before.
    pub before: Vec3,
}

/// The light of a path that has met a catcher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caught {
    /// As it met it.
    pub split: Split,
    /// In the scene of the catchers alone.
    pub alone: Vec3,
    /// Of the world behind the catcher.
    pub behind: Vec3,
}

impl Caught {
    /// Whether all of it is.
    pub fn is_finite(&self) -> bool {
        let Split { throughput, before } = self.split;
        let mut all = [throughput, before, self.alone, self.behind].into_iter();
        all.all(Vec3::is_finite)
    }
}

/// Sums of a pixel's paths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CatcherPixel {
    /// Light of what is no catcher.
    objects: DVec3,
    /// How much of the paths shows none of it.
    past: f64,
    /// Light on the catchers alone.
    alone: DVec3,
    /// The world, also behind catchers.
    world: DVec3,
    /// Paths that have met a catcher.
    count: f64,
}

impl CatcherPixel {
    /// From its floats.
    pub fn read(sums: &[f64]) -> Self {
        let at = |i: usize| sums.get(i).copied().unwrap_or(0.0);
        let color = |i: usize| DVec3::new(at(i), at(i + 1), at(i + 2));
        Self {
            objects: color(0),
            past: at(3),
            alone: color(4),
            world: color(7),
            count: at(10),
        }
    }

    /// Its floats.
    pub fn write(&self, sums: &mut [f64]) {
        let floats = (self.objects.to_array().into_iter())
            .chain([self.past])
            .chain(self.alone.to_array())
            .chain(self.world.to_array())
            .chain([self.count]);
        sums.iter_mut()
            .zip(floats)
            .for_each(|(sum, float)| *sum = float);
    }

    /// Adds a path that has met no catcher: its light, that of the world straight to the camera, and whether it is no part of the
    /// picture.
    pub fn add(&mut self, light: Vec3, world: Vec3, transparent: bool) {
        self.objects += light.as_dvec3();
        self.world += world.as_dvec3();
        self.past += f64::from(u8::from(transparent));
    }

    /// Adds one that has.
    pub fn add_caught(&mut self, caught: &Caught, exposure: f32) {
        self.objects += (caught.split.before * exposure).as_dvec3();
        self.past += f64::from(average(caught.split.throughput));
        self.alone += (caught.alone * exposure).as_dvec3();
        self.world += (caught.behind * exposure).as_dvec3();
        self.count += 1.0;
    }

    /// What the objects do to the light on the catchers, given the mean of all light and the pixel's alpha: the pass of that name.
    pub fn shadow(&self, all: DVec3, alpha: f64, scale: f64) -> DVec3 {
        if self.count == 0.0 {
            return DVec3::ONE;
        }
        let (lit, alone) = (all - self.objects * scale, self.alone * scale);
        let of = |lit: f64, alone: f64| if alone != 0.0 { lit / alone } else { 1.0 };
        let ratio = DVec3::new(of(lit.x, alone.x), of(lit.y, alone.y), of(lit.z, alone.z));
        DVec3::ONE.lerp(ratio, alpha.clamp(0.0, 1.0))
    }

    /// The objects over nothing, for who has the pass of shadows to multiply a photograph with.
    pub fn objects(&self, scale: f64) -> (DVec3, f64) {
        let alpha = (1.0 - self.past * scale).clamp(0.0, 1.0);
        (self.objects * scale, alpha)
    }

    /// The world, also behind catchers.
    pub fn world(&self, scale: f64) -> DVec3 {
        self.world * scale
    }

    /// The objects over their shadows: over the world, or over nothing where the film is transparent. A shadow is black there, and
    /// as opaque as it is dark.
    pub fn combined(&self, all: DVec3, alpha: f64, transparent: bool, scale: f64) -> (DVec3, f64) {
        let (objects, covers) = self.objects(scale);
        let shadow = self.shadow(all, alpha, scale);
        let darkness = 1.0 - (shadow.element_sum() / 3.0).clamp(0.0, 1.0);
        let alpha = (1.0 - covers) * darkness + covers;
        if transparent {
            return (objects, alpha);
        }
        (objects + self.world * scale * (1.0 - alpha), 1.0)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/catchers.rs"]
mod tests;
