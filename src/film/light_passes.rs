//! Light kept apart by what the surface that the camera sees does to it, as Cycles' passes have it:
//! the shares of the first scattering decide for all that the path finds later.

use super::catchers::Split;
use super::features::{PathFeatures, SurfaceFeatures};
use super::objects::FirstObject;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// What a path tells of its light besides the sum. The path loop is compiled with one of these: with
/// [`NoPasses`] nothing of it is left.
pub trait PassSink {
    /// A surface that the camera sees, whose light reaches it by this much: shares of light that it scatters diffusely, reflects
    /// otherwise, and lets through. Surfaces that the path passes have theirs, too.
    #[inline(always)]
    fn first_colors(&mut self, _throughput: Vec3, _colors: impl FnOnce() -> [Vec3; 3]) {}
    /// The first surface of which enough is there: its texture coordinates.
    #[inline(always)]
    fn first_surface(&mut self, _uv: impl FnOnce() -> Vec2) {}
    /// How that surface scatters light from a direction: all of it, the diffuse part, and the share of the rest that is let
    /// through.
    #[inline(always)]
    fn first_scattering(&mut self, _whole: Vec3, _diffuse: Vec3, _through: impl FnOnce() -> Vec3) {}
    /// The first scattering is in a medium.
    #[inline(always)]
    fn first_in_medium(&mut self) {}
    /// A medium with an albedo scatters the path; and what points toward the camera.
    #[inline(always)]
    fn scatter(&mut self, _albedo: impl FnOnce() -> Vec3, _toward_camera: impl FnOnce() -> Vec3) {}
    /// One of several paths goes on from there, by its number.
    #[inline(always)]
    fn branch(&mut self, _number: u32) {}
    /// Light by way of that surface; `indirect`: by way of others too.
    #[inline(always)]
    fn scattered(&mut self, _light: Vec3, _indirect: bool) {}
    /// Light of a surface that shines, straight to the camera.
    #[inline(always)]
    fn emission(&mut self, _light: Vec3) {}
    /// Light of the world, straight to the camera.
    #[inline(always)]
    fn environment(&mut self, _light: Vec3) {}
    /// A ray has met a surface after a distance, whichever it is.
    #[inline(always)]
    fn meet(&mut self, _distance: f32) {}
    /// A ray passes what it has met after a distance.
    #[inline(always)]
    fn go_by(&mut self, _distance: f32) {}
    /// What that surface is to denoisers.
    #[inline(always)]
    fn surface(&mut self, _features: impl FnOnce() -> SurfaceFeatures) {}
    /// Light that a ray has found, wherever it comes from.
    #[inline(always)]
    fn shine(&mut self, _light: Vec3) {}
    /// A surface that the camera sees: the first that the path does not pass, and those that it passes before.
    #[inline(always)]
    fn first_object(&mut self, _object: impl FnOnce() -> FirstObject) {}
    /// Whether ambient occlusion is asked for.
    #[inline(always)]
    fn asks_occlusion(&self) -> bool {
        false
    }
    /// Ambient occlusion of that surface, by what a ray meets within a distance. Rays that it took.
    #[inline(always)]
    fn occlusion(&mut self, _open: impl FnOnce(f32) -> Vec3) -> u32 {
        0
    }
    /// The path goes on through a surface that tints it.
    #[inline(always)]
    fn pass(&mut self, _tint: Vec3) {}
    /// The first surface has sent the path elsewhere: what is there is the first. Its colours stay, as its light does.
    #[inline(always)]
    fn leave_first(&mut self) {}
    /// Whether light groups have the world where it is no part of the picture: in Cycles if its pass is asked for.
    #[inline(always)]
    fn keeps_environment(&self) -> bool {
        false
    }
    /// The path has met a shadow catcher.
    #[inline(always)]
    fn split(&mut self, _split: impl FnOnce() -> Split) {}
    /// Light of a light group, by its number.
    #[inline(always)]
    fn grouped(&mut self, _light: Vec3, _group: impl FnOnce() -> Option<usize>) {}
}

/// All light is one.
pub struct NoPasses;

impl PassSink for NoPasses {}

/// Kinds of scattering by surfaces: diffuse, glossy, transmission.
const KINDS: usize = 3;
/// That by media comes after them.
const MEDIA: usize = KINDS;

/// The light of one path, apart.
#[derive(Clone, Debug, Default)]
pub struct PathPasses {
    /// By kind of scattering; direct and indirect.
    light: [[Vec3; 2]; KINDS + 1],
    colors: [Vec3; KINDS],
    emission: Vec3,
    environment: Vec3,
    uv: Vec2,
    covered: bool,
    diffuse_share: Vec3,
    /// Kind of what is not diffuse.
    other: usize,
    /// Share of that which is let through, where it is reflected or let through.
    through: Vec3,
    /// For denoisers.
    pub features: PathFeatures,
    /// What was met first and on the way there, if it is asked for.
    pub objects: Vec<FirstObject>,
    /// By light group.
    pub groups: Vec<Vec3>,
    /// Where it has met a shadow catcher. What comes by way of that is in no pass of light, as in Cycles.
    pub split: Option<Split>,
    asked: Asked,
}

/// What paths are asked for besides their light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked {
    /// Features for denoisers.
    pub features: bool,
    /// What they meet first.
    pub object: bool,
    /// How far ambient occlusion looks, metres.
    pub occlusion: Option<f32>,
    /// How many light groups there are …
    pub groups: usize,
    /// … which have the world where it is no part of the picture.
    pub environment: bool,
}

impl PathPasses {
    /// A path that is asked for something.
    pub fn new(asked: Asked) -> Self {
        let mut path = Self {
            groups: vec![Vec3::ZERO; asked.groups],
            asked,
            ..Self::default()
        };
        if asked.features {
            path.features = PathFeatures::FOLLOWED;
        }
        path
    }

    /// Whether all of it is.
    pub fn is_finite(&self) -> bool {
        let light = self.light.iter().flatten().chain(&self.colors);
        let alone = [self.emission, self.environment];
        let light = light.chain(&alone).chain(&self.groups);
        light.copied().all(Vec3::is_finite)
            && self.uv.is_finite()
            && self.features.is_finite()
            && self.objects.iter().all(FirstObject::is_finite)
    }

    /// Tells of data what the ray through the pixel's middle tells: texture coordinates, and what it meets.
    pub fn center(&mut self, met: Option<(Vec2, FirstObject)>) {
        self.uv = met.map_or(Vec2::ZERO, |(uv, _)| uv);
        self.covered = met.is_some();
        // Ambient occlusion is not of the middle alone.
        let open = self.objects.drain(..).map(|object| object.open).sum();
        if self.asked.object {
            let nothing = FirstObject::default();
            let object = met.map_or(nothing, |(_, object)| object);
            self.objects.push(FirstObject { open, ..object });
        }
    }

    /// Light of the world, straight to the camera.
    pub fn of_environment(&self) -> Vec3 {
        self.environment
    }

    /// Scales the light; what surfaces are like stays as it is.
    pub fn expose(&mut self, factor: f32) {
        for light in self.light.iter_mut().flatten().chain(&mut self.groups) {
            *light *= factor;
        }
        self.emission *= factor;
        self.environment *= factor;
    }
}

impl PassSink for PathPasses {
    #[inline]
    fn first_colors(&mut self, throughput: Vec3, colors: impl FnOnce() -> [Vec3; KINDS]) {
        for (sum, color) in self.colors.iter_mut().zip(colors()) {
            *sum += throughput * color;
        }
    }

    #[inline]
    fn first_surface(&mut self, uv: impl FnOnce() -> Vec2) {
        self.uv = uv();
        self.covered = true;
    }

    #[inline]
    fn first_scattering(&mut self, whole: Vec3, diffuse: Vec3, through: impl FnOnce() -> Vec3) {
        // Where nothing is scattered there is nothing to share out.
        let share = |diffuse: f32, whole: f32| if whole > 0.0 { diffuse / whole } else { 0.0 };
        self.diffuse_share = Vec3::new(
            share(diffuse.x, whole.x),
            share(diffuse.y, whole.y),
            share(diffuse.z, whole.z),
        );
        (self.other, self.through) = (1, through());
    }

    #[inline]
    fn first_in_medium(&mut self) {
        (self.diffuse_share, self.other) = (Vec3::ZERO, MEDIA);
    }

    #[inline]
    fn branch(&mut self, number: u32) {
        self.features.branch(number);
    }

    #[inline]
    fn split(&mut self, split: impl FnOnce() -> Split) {
        self.split = Some(split());
    }

    #[inline]
    fn scattered(&mut self, light: Vec3, indirect: bool) {
        if self.split.is_some() {
            return;
        }
        let indirect = usize::from(indirect);
        let diffuse = light * self.diffuse_share;
        let rest = light - diffuse;
        self.light[0][indirect] += diffuse;
        if self.other == 1 {
            let through = rest * self.through;
            self.light[1][indirect] += rest - through;
            self.light[2][indirect] += through;
        } else {
            self.light[self.other][indirect] += rest;
        }
    }

    #[inline]
    fn emission(&mut self, light: Vec3) {
        self.emission += light;
    }

    #[inline]
    fn environment(&mut self, light: Vec3) {
        self.environment += light;
    }

    #[inline]
    fn meet(&mut self, distance: f32) {
        self.features.meet(distance);
    }

    #[inline]
    fn go_by(&mut self, distance: f32) {
        self.features.go_by(distance);
    }

    #[inline]
    fn surface(&mut self, features: impl FnOnce() -> SurfaceFeatures) {
        self.features.surface(features);
    }

    #[inline]
    fn scatter(&mut self, albedo: impl FnOnce() -> Vec3, toward_camera: impl FnOnce() -> Vec3) {
        self.features.scatter(albedo, toward_camera);
    }

    #[inline]
    fn shine(&mut self, light: Vec3) {
        self.features.shine(light);
    }

    #[inline]
    fn first_object(&mut self, object: impl FnOnce() -> FirstObject) {
        if self.asked.object {
            self.objects.push(object());
        }
    }

    #[inline]
    fn asks_occlusion(&self) -> bool {
        self.asked.occlusion.is_some()
    }

    #[inline]
    fn occlusion(&mut self, open: impl FnOnce(f32) -> Vec3) -> u32 {
        let Some(distance) = self.asked.occlusion else {
            return 0;
        };
        if let Some(object) = self.objects.last_mut() {
            object.open = open(distance);
        }
        1
    }

    #[inline]
    fn pass(&mut self, tint: Vec3) {
        self.features.pass(tint);
    }

    #[inline]
    fn leave_first(&mut self) {
        (self.uv, self.covered) = (Vec2::ZERO, false);
        self.objects.pop();
    }

    #[inline]
    fn keeps_environment(&self) -> bool {
        self.asked.environment
    }

    #[inline]
    fn grouped(&mut self, light: Vec3, group: impl FnOnce() -> Option<usize>) {
        if self.asked.groups > 0
            && self.split.is_none()
            && let Some(sum) = group().and_then(|group| self.groups.get_mut(group))
        {
            *sum += light;
        }
    }
}

/// Sums of a pixel's paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelPasses {
    light: [[DVec3; 2]; KINDS + 1],
    colors: [DVec3; KINDS],
    emission: DVec3,
    environment: DVec3,
    uv: DVec2,
    covered: u64,
}

fn add_each(sums: &mut [DVec3], values: impl Iterator<Item = DVec3>) {
    sums.iter_mut()
        .zip(values)
        .for_each(|(sum, value)| *sum += value);
}

impl PixelPasses {
    /// Adds a path.
    pub fn add(&mut self, path: &PathPasses) {
        let lights = path.light.as_flattened().iter().map(|v| v.as_dvec3());
        add_each(self.light.as_flattened_mut(), lights);
        add_each(&mut self.colors, path.colors.iter().map(|v| v.as_dvec3()));
        self.emission += path.emission.as_dvec3();
        self.environment += path.environment.as_dvec3();
        self.uv += path.uv.as_dvec2();
        self.covered += u64::from(path.covered);
    }

    /// Whether it can be what so many paths have made: for one that comes from a file.
    pub fn is_sound(&self, samples: u32) -> bool {
        let light = self.light.iter().flatten().chain(&self.colors);
        let alone = [self.emission, self.environment];
        light.chain(&alone).all(|v| v.is_finite())
            && self.uv.is_finite()
            && self.covered <= u64::from(samples)
    }

    /// Adds the paths of another sum.
    pub fn join(&mut self, other: &Self) {
        add_each(
            self.light.as_flattened_mut(),
            other.light.as_flattened().iter().copied(),
        );
        add_each(&mut self.colors, other.colors.iter().copied());
        self.emission += other.emission;
        self.environment += other.environment;
        self.uv += other.uv;
        self.covered += other.covered;
    }

    /// Light over colour: of diffuse (0), glossy (1) or transmitted light (2), direct or indirect. Both are
    /// sums over the same samples. Where a colour has a channel without any share there is no such light;
    /// Cycles puts what the other channels say there, and so it is here.
    pub fn light(&self, kind: usize, indirect: bool) -> DVec3 {
        let (light, color) = (self.light[kind][usize::from(indirect)], self.colors[kind]);
        let mut ratio = DVec3::ZERO;
        let mut known = (0.0, 0.0);
        for i in 0..3 {
            if color[i] != 0.0 {
                ratio[i] = light[i] / color[i];
                known = (known.0 + ratio[i], known.1 + 1.0);
            }
        }
        if known.1 > 0.0 {
            for i in 0..3 {
                if color[i] == 0.0 {
                    ratio[i] = known.0 / known.1;
                }
            }
        }
        ratio
    }

    /// Mean colour of a kind, given the reciprocal of the number of samples.
    pub fn color(&self, kind: usize, scale: f64) -> DVec3 {
        self.colors[kind] * scale
    }

    /// Mean light that media scatter, direct or indirect.
    pub fn of_media(&self, indirect: bool, scale: f64) -> DVec3 {
        self.light[MEDIA][usize::from(indirect)] * scale
    }

    /// Mean emission.
    pub fn emission(&self, scale: f64) -> DVec3 {
        self.emission * scale
    }

    /// Mean of the world.
    pub fn environment(&self, scale: f64) -> DVec3 {
        self.environment * scale
    }

    /// Mean texture coordinates, and the share of the samples that met a surface.
    pub fn uv(&self, scale: f64) -> [f32; 3] {
        [
            (self.uv.x * scale) as f32,
            (self.uv.y * scale) as f32,
            (self.covered as f64 * scale) as f32,
        ]
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/light_passes.rs"]
mod tests;
