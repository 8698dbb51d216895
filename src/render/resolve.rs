//! From the sums of the pixels to the passes of a picture.

use super::Region;
use super::tile::{TILE, Tile, across, catcher_sums, locked, shown};
use crate::film::catchers::{CATCHER_SUMS, CatcherPixel};
use crate::film::features::PixelFeatures;
use crate::film::light_passes::PixelPasses;
use crate::film::objects::{Label, PixelObjects};
use crate::film::pixel::{NO_DEPTH, Pixel};
use crate::film::{Bands, Pass, Passes, group_layers};
use crate::integrator::VECTOR_SUMS;
use crate::scene::Aov;
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Range;
use std::sync::Mutex;

/// Blender's axes (Z up) from Sundog's (Y up).
fn blender_axes(v: DVec3) -> [f32; 3] {
    [v.x as f32, -v.z as f32, v.y as f32]
}

/// How a picture shows shadow catchers, as Cycles has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Catching {
    /// Not at all: a pass has the shadows.
    apart: bool,
    /// The world is a part of the picture.
    over_world: bool,
}

/// The pixels so far, as a picture.
pub struct Film<'a> {
    tiles: &'a [Mutex<Tile>],
    region: Region,
    passes: Passes,
    /// What is known of objects, by their numbers; empty where no pass asks.
    labels: &'a [Label],
    /// Light groups with a pass each.
    groups: &'a [String],
    /// The scene's own passes, where they are asked for.
    aovs: &'a [Aov],
    /// Shadow catchers, if there are any: how the picture shows them.
    catchers: Option<Catching>,
    /// Pixels across and down the whole picture.
    size: (u32, u32),
    /// The camera's axes as Cycles has them: it looks along +Z.
    axes: DMat3,
    /// `Combined` is the picture of one replicate alone: of the second one?
    replicate: Option<bool>,
}

impl<'a> Film<'a> {
    /// The passes of a region that these tiles, row by row, make up.
    pub fn new(
        world_from_camera: &DAffine3,
        region: Region,
        tiles: &'a [Mutex<Tile>],
        passes: Passes,
        labels: &'a [Label],
    ) -> Self {
        let m = &world_from_camera.matrix3;
        let axes = DMat3::from_cols(
            m.x_axis.normalize_or_zero(),
            m.y_axis.normalize_or_zero(),
            -m.z_axis.normalize_or_zero(),
        );
        Self::with_axes(axes, region, tiles, passes, labels)
    }

    /// With axes that [`axes`](Self::axes) has given.
    pub fn with_axes(
        axes: DMat3,
        region: Region,
        tiles: &'a [Mutex<Tile>],
        passes: Passes,
        labels: &'a [Label],
    ) -> Self {
        Self {
            labels,
            groups: &[],
            aovs: &[],
            catchers: None,
            size: (region.x1, region.y1),
            tiles,
            region,
            passes,
            axes,
            replicate: None,
        }
    }

    /// With passes of the scene's own, and of a picture of a size.
    pub fn with_aovs(self, aovs: &'a [Aov], size: (u32, u32)) -> Self {
        Self { aovs, size, ..self }
    }

    /// With shadow catchers, if there are any, on a film that is transparent or not.
    pub fn with_catchers(self, there: bool, transparent: bool) -> Self {
        let how = Catching {
            apart: self.passes.has(Pass::ShadowCatcher),
            over_world: !transparent,
        };
        Self {
            catchers: there.then_some(how),
            ..self
        }
    }

    /// The camera's axes.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// What is known of objects.
    pub fn labels(&self) -> &'a [Label] {
        self.labels
    }

    /// What it is made of.
    pub fn tiles(&self) -> &'a [Mutex<Tile>] {
        self.tiles
    }

    /// The tiles of a band.
    fn tiles_of(&self, band: usize) -> &'a [Mutex<Tile>] {
        let mut bands = self.tiles.chunks(across(self.region));
        bands.nth(band).unwrap_or(&[])
    }

    /// With the passes of these light groups.
    #[must_use]
    pub fn with_groups(self, groups: &'a [String]) -> Self {
        Self { groups, ..self }
    }

    /// With other passes, and none of light groups.
    pub fn with(&self, passes: Passes) -> Self {
        Self {
            passes,
            groups: &[],
            ..*self
        }
    }

    /// Estimated variance of each pixel's luminance; `None` if one of them has not enough samples.
    pub fn luminance_variances(&self) -> Option<Vec<f32>> {
        let width = self.region.width() as usize;
        let mut variances = vec![0.0; width * self.region.height() as usize];
        for tile in self.tiles {
            let tile = locked(tile);
            let corner =
                (tile.y - self.region.y0) as usize * width + (tile.x - self.region.x0) as usize;
            for (row, pixels) in tile.pixels.chunks(tile.width.max(1) as usize).enumerate() {
                let places = &mut variances[corner + row * width..];
                for (place, pixel) in places.iter_mut().zip(pixels) {
                    *place = pixel.luminance_variance()? as f32;
                }
            }
        }
        Some(variances)
    }

    /// The picture of the first replicate alone, or of the second.
    pub fn replicate(&self, second: bool) -> Self {
        Self {
            replicate: Some(second),
            ..self.with(Passes::COMBINED)
        }
    }
}

impl Bands for Film<'_> {
    fn size(&self) -> (u32, u32) {
        (self.region.width(), self.region.height())
    }

    fn layers(&self) -> Vec<(String, String)> {
        let aovs = shown(self.passes, self.aovs).iter();
        let aovs = aovs.map(|aov| (aov.name.clone(), aov.channels().into()));
        let groups = group_layers(self.groups);
        self.passes.layers().chain(aovs).chain(groups).collect()
    }

    fn bands(&self) -> Vec<Range<u32>> {
        let height = self.region.height();
        let starts = (0..height).step_by(TILE as usize);
        starts.map(|from| from..(from + TILE).min(height)).collect()
    }

    fn is_begun(&self, band: usize) -> bool {
        let has_all = |tile: &Mutex<Tile>| locked(tile).pixels.iter().all(|p| p.samples > 0);
        self.tiles_of(band).iter().all(has_all)
    }

    fn fill(&self, band: usize, layers: &mut [&mut [f32]]) {
        let width = self.region.width() as usize;
        for tile in self.tiles_of(band) {
            let tile = locked(tile);
            let place = TileInBand {
                tile: &tile,
                column: (tile.x - self.region.x0) as usize,
                width,
                labels: self.labels,
                size: self.size,
                catchers: self.catchers,
            };
            // Pass by pass: the sums of one tile stay in the processor's cache.
            let mut layers = layers.iter_mut();
            let passes = self.passes.iter().filter(|pass| *pass != Pass::Aov);
            for (pass, layer) in passes.zip(&mut layers) {
                place.resolve(pass, &self.axes, self.replicate, layer);
            }
            let mut first = catcher_sums(self.catchers.is_some());
            for (aov, layer) in shown(self.passes, self.aovs).iter().zip(&mut layers) {
                if aov.is_color {
                    place.put_aov::<4>(first, layer);
                } else {
                    place.put_aov::<1>(first, layer);
                }
                first += aov.channels().len();
            }
            for (group, layer) in layers.enumerate() {
                place.put_at(layer, |index, _, scale| {
                    let sum = tile.groups[tile.groups_of(index..index + 1)][group];
                    (sum * scale).as_vec3().to_array()
                });
            }
        }
    }
}

/// A tile, and where it lies in its band.
struct TileInBand<'a> {
    tile: &'a Tile,
    column: usize,
    width: usize,
    labels: &'a [Label],
    /// Pixels across and down the whole picture.
    size: (u32, u32),
    catchers: Option<Catching>,
}

impl TileInBand<'_> {
    /// Writes a value of each pixel: of its sums and the reciprocal of the number of its samples.
    #[inline]
    fn put<const N: usize>(
        &self,
        layer: &mut [f32],
        value: impl Fn(&Pixel, &PixelPasses, f64) -> [f32; N],
    ) {
        let nothing = PixelPasses::default();
        self.put_at(layer, |index, pixel, scale| {
            let passes = self.tile.light_passes.get(index);
            value(pixel, passes.unwrap_or(&nothing), scale)
        });
    }

    /// The same of its features for denoisers.
    fn put_features<const N: usize>(
        &self,
        layer: &mut [f32],
        value: impl Fn(&PixelFeatures, f64) -> [f32; N],
    ) {
        let nothing = PixelFeatures::default();
        self.put_at(layer, |index, _, scale| {
            value(self.tile.features.get(index).unwrap_or(&nothing), scale)
        });
    }

    /// The same of its motion, in pixels: the mean of the samples that have one.
    fn put_vectors(&self, layer: &mut [f32]) {
        let (width, height) = self.size;
        let pixels = [width, height, width, height].map(f64::from);
        self.put_at(layer, |index, _, _| {
            let end = self.tile.aovs_of(&(index..index + 1)).end;
            let sums = end
                .checked_sub(VECTOR_SUMS)
                .and_then(|first| self.tile.aovs.get(first..end));
            let Some(&[.., count]) = sums.filter(|sums| sums[4] > 0.0) else {
                return [0.0; 4];
            };
            let of = |i: usize| sums.map_or(0.0, |sums| sums[i] / count * pixels[i]) as f32;
            [of(0), of(1), of(2), of(3)]
        });
    }

    /// The same of what it was told for a pass of the scene's own, whose first float is known.
    fn put_aov<const N: usize>(&self, first: usize, layer: &mut [f32]) {
        self.put_at(layer, |index, _, scale| {
            let place = self.tile.aovs_of(&(index..index + 1)).start + first;
            let sums = self.tile.aovs.get(place..place + N);
            std::array::from_fn::<f32, N, _>(|i| sums.map_or(0.0, |sums| (sums[i] * scale) as f32))
        });
    }

    /// What a pixel has of shadow catchers.
    fn caught(&self, index: usize) -> CatcherPixel {
        let first = self.tile.aovs_of(&(index..index + 1)).start;
        let sums = self.tile.aovs.get(first..first + CATCHER_SUMS);
        CatcherPixel::read(sums.unwrap_or(&[]))
    }

    /// The same of its objects.
    fn put_objects<const N: usize>(
        &self,
        layer: &mut [f32],
        value: impl Fn(&PixelObjects, f64) -> [f32; N],
    ) {
        let nothing = PixelObjects::default();
        self.put_at(layer, |index, _, scale| {
            value(self.tile.objects.get(index).unwrap_or(&nothing), scale)
        });
    }

    /// The same by the pixel's number in the tile.
    #[inline]
    fn put_at<const N: usize>(
        &self,
        layer: &mut [f32],
        value: impl Fn(usize, &Pixel, f64) -> [f32; N],
    ) {
        let across = self.tile.width as usize;
        for (row, pixels) in self.tile.pixels.chunks(across.max(1)).enumerate() {
            let start = (row * self.width + self.column) * N;
            let places = layer[start..start + across * N].chunks_exact_mut(N);
            for (i, (pixel, place)) in pixels.iter().zip(places).enumerate() {
                let scale = if pixel.samples > 0 {
                    1.0 / f64::from(pixel.samples)
                } else {
                    0.0
                };
                place.copy_from_slice(&value(row * across + i, pixel, scale));
            }
        }
    }

    /// Writes values that stand beside the pixels; where there are none, another.
    fn put_beside(&self, layer: &mut [f32], values: impl Iterator<Item = f32>, otherwise: f32) {
        let across = self.tile.width as usize;
        let mut values = values.chain(std::iter::repeat(otherwise));
        for row in 0..self.tile.height as usize {
            let start = row * self.width + self.column;
            for (place, value) in layer[start..start + across].iter_mut().zip(&mut values) {
                *place = value;
            }
        }
    }

    fn resolve(&self, pass: Pass, axes: &DMat3, replicate: Option<bool>, layer: &mut [f32]) {
        let color = |v: DVec3| v.as_vec3().to_array();
        match pass {
            Pass::Combined | Pass::NoisyImage => self.put_at(layer, |index, p, scale| {
                let alone = replicate.and_then(|second| p.replicate(second));
                let mean = || p.radiance.total() * scale;
                // Exactly 1 where every sample is part of the picture.
                let alpha = 1.0 - f64::from(p.transparent) * scale;
                let (light, alpha) = match self.catchers {
                    None => (alone.unwrap_or_else(mean), alpha),
                    Some(how) => {
                        let sums = self.caught(index);
                        let (light, shown) = if how.apart {
                            sums.objects(scale)
                        } else {
                            sums.combined(mean(), alpha, !how.over_world, scale)
                        };
                        // The replicate has the noise of all light, as the estimate of the error.
                        let apart = alone.map_or(DVec3::ZERO, |alone| alone - mean());
                        (light + apart, shown)
                    }
                };
                let [r, g, b] = color(light);
                [r, g, b, alpha as f32]
            }),
            Pass::ShadowCatcher => self.put_at(layer, |index, p, scale| {
                let alpha = 1.0 - f64::from(p.transparent) * scale;
                let sums = match self.catchers {
                    Some(_) => self.caught(index),
                    None => CatcherPixel::default(),
                };
                color(sums.shadow(p.radiance.total() * scale, alpha, scale))
            }),
            Pass::Depth => self.put(layer, |p, _, _| [p.middle.depth]),
            Pass::Normal => self.put(layer, |p, _, scale| blender_axes(p.normal.total() * scale)),
            Pass::Position => {
                self.put(layer, |p, _, _| blender_axes(p.middle.position.as_dvec3()));
            }
            Pass::Uv => self.put(layer, |_, a, scale| a.uv(scale)),
            Pass::DiffuseDirect => self.put(layer, |_, a, _| color(a.light(0, false))),
            Pass::DiffuseIndirect => self.put(layer, |_, a, _| color(a.light(0, true))),
            Pass::DiffuseColor => self.put(layer, |_, a, scale| color(a.color(0, scale))),
            Pass::GlossyDirect => self.put(layer, |_, a, _| color(a.light(1, false))),
            Pass::GlossyIndirect => self.put(layer, |_, a, _| color(a.light(1, true))),
            Pass::GlossyColor => self.put(layer, |_, a, scale| color(a.color(1, scale))),
            Pass::TransmissionDirect => self.put(layer, |_, a, _| color(a.light(2, false))),
            Pass::TransmissionIndirect => self.put(layer, |_, a, _| color(a.light(2, true))),
            Pass::TransmissionColor => self.put(layer, |_, a, scale| color(a.color(2, scale))),
            Pass::VolumeDirect => self.put(layer, |_, a, scale| color(a.of_media(false, scale))),
            Pass::VolumeIndirect => self.put(layer, |_, a, scale| color(a.of_media(true, scale))),
            Pass::Emission => self.put(layer, |_, a, scale| color(a.emission(scale))),
            // As Cycles' pass: also behind catchers, if the picture has it.
            Pass::Environment if self.catchers.is_some_and(|how| how.over_world) => {
                self.put_at(layer, |index, _, scale| {
                    color(self.caught(index).world(scale))
                });
            }
            Pass::Environment => self.put(layer, |_, a, scale| color(a.environment(scale))),
            Pass::Vector => self.put_vectors(layer),
            Pass::Mist => self.put_objects(layer, |o, scale| [o.mist(scale)]),
            Pass::AmbientOcclusion => self.put_objects(layer, |o, scale| o.open(scale)),
            Pass::ObjectIndex => self.put_objects(layer, |o, _| [o.index(self.labels, false)]),
            Pass::MaterialIndex => self.put_objects(layer, |o, _| [o.index(self.labels, true)]),
            Pass::CryptoObject00
            | Pass::CryptoObject01
            | Pass::CryptoObject02
            | Pass::CryptoMaterial00
            | Pass::CryptoMaterial01
            | Pass::CryptoMaterial02
            | Pass::CryptoAsset00
            | Pass::CryptoAsset01
            | Pass::CryptoAsset02 => {
                if let Some((kind, rank)) = pass.matte() {
                    self.put_objects(layer, |o, scale| o.mattes(self.labels, kind, rank, scale));
                }
            }
            Pass::DenoisingAlbedo => self.put_features(layer, |f, scale| color(f.albedo(scale))),
            Pass::DenoisingNormal => {
                self.put_features(layer, |f, scale| color(axes.transpose() * f.normal(scale)))
            }
            Pass::DenoisingDepth => self.put_features(layer, |f, scale| {
                [f.depth(scale).map_or(NO_DEPTH, |depth| depth as f32)]
            }),
            Pass::SampleCount => self.put(layer, |p, _, _| [p.samples as f32]),
            Pass::Error => {
                let errors = self.tile.errors.iter();
                self.put_beside(layer, errors.map(|error| error.sqrt()), f32::INFINITY);
            }
            Pass::Cost => {
                self.put_beside(layer, self.tile.costs.iter().map(|&ns| ns as f32), 0.0);
            }
            // They have layers of their own.
            Pass::Aov => {}
        }
    }
}
