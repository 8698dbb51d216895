//! Tiles, and their rows: what one thread works on at a time.

use super::catchers::has_catchers;
use super::{Region, RenderSettings};
use crate::film::catchers::CATCHER_SUMS;
use crate::film::features::PixelFeatures;
use crate::film::light_passes::PixelPasses;
use crate::film::objects::PixelObjects;
use crate::film::pixel::Pixel;
use crate::film::{Pass, Passes};
use crate::integrator::{Center, VECTOR_SUMS};
use crate::scene::Aov;
use crate::scene::Scene;
use glam::DVec3;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Edge of a tile in pixels.
pub const TILE: u32 = 32;

/// A tile of the region; places count from the corner of the full picture.
pub struct Tile {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row.
    pub pixels: Vec<Pixel>,
    /// Beside `pixels`, if a pass asks for it; else empty.
    pub light_passes: Vec<PixelPasses>,
    /// The same.
    pub features: Vec<PixelFeatures>,
    /// The same.
    pub objects: Vec<PixelObjects>,
    /// The same of light groups: so many of each pixel, one after another.
    pub groups: Vec<DVec3>,
    /// Sums of shadow catchers and of the scene's own passes, so many floats a pixel; empty where nothing asks.
    pub aovs: Vec<f64>,
    /// Nanoseconds spent on each pixel, if a pass asks for it; else empty.
    pub costs: Vec<u64>,
    /// Radiance of half of each pixel's samples, if a noise threshold asks for it; else empty.
    pub halves: Vec<DVec3>,
    /// Squared relative error of each pixel, as it was estimated last; empty before.
    pub errors: Vec<f32>,
    /// What adaptive sampling decides by; empty without it.
    pub deciding: Vec<f32>,
    /// What the rays through the middles of pixels have met, if passes of data are theirs: `None` before they were traced. Empty
    /// where nothing asks. No part of a state: whoever goes on from one traces them once more.
    pub centers: Vec<Option<Option<Center>>>,
    /// Luminance that clamping took from direct and indirect light, row by row: summed in their order, whichever thread
    /// is done first.
    pub clamped: Vec<[f64; 2]>,
}

/// A row of a tile, taken out to be worked on.
pub struct Scanline {
    /// First column, and row, in the full picture.
    pub place: (u32, u32),
    /// As those of [`Tile`].
    pub pixels: Vec<Pixel>,
    /// As those of [`Tile`].
    pub light_passes: Vec<PixelPasses>,
    /// As those of [`Tile`].
    pub features: Vec<PixelFeatures>,
    /// As those of [`Tile`].
    pub objects: Vec<PixelObjects>,
    /// As those of [`Tile`].
    pub groups: Vec<DVec3>,
    pub aovs: Vec<f64>,
    /// As those of [`Tile`].
    pub costs: Vec<u64>,
    /// As those of [`Tile`].
    pub halves: Vec<DVec3>,
    /// As those of [`Tile`].
    pub centers: Vec<Option<Option<Center>>>,
    /// As those of [`Tile`].
    pub clamped: [f64; 2],
}

impl Tile {
    /// A copy of a row, if it lacks samples.
    pub fn unfinished(&self, row: u32) -> Option<Scanline> {
        let place = self.place_of(row);
        let pixels = &self.pixels[place.clone()];
        if pixels.iter().all(|pixel| pixel.samples >= pixel.until) {
            return None;
        }
        Some(Scanline {
            place: (self.x, self.y + row),
            pixels: pixels.to_vec(),
            light_passes: self.light_passes.get(place.clone()).unwrap_or(&[]).to_vec(),
            features: self.features.get(place.clone()).unwrap_or(&[]).to_vec(),
            objects: self.objects.get(place.clone()).unwrap_or(&[]).to_vec(),
            groups: self.groups[self.groups_of(place.clone())].to_vec(),
            aovs: self.aovs[self.aovs_of(&place)].to_vec(),
            costs: self.costs.get(place.clone()).unwrap_or(&[]).to_vec(),
            halves: self.halves.get(place.clone()).unwrap_or(&[]).to_vec(),
            centers: self.centers.get(place).unwrap_or(&[]).to_vec(),
            clamped: self.clamped[row as usize],
        })
    }

    /// Puts back what [`unfinished`](Self::unfinished) has given.
    pub fn put_back(&mut self, row: u32, done: &Scanline) {
        let place = self.place_of(row);
        self.pixels[place.clone()].copy_from_slice(&done.pixels);
        if let Some(light_passes) = self.light_passes.get_mut(place.clone()) {
            light_passes.copy_from_slice(&done.light_passes);
        }
        if let Some(features) = self.features.get_mut(place.clone()) {
            features.copy_from_slice(&done.features);
        }
        if let Some(objects) = self.objects.get_mut(place.clone()) {
            objects.copy_from_slice(&done.objects);
        }
        let groups = self.groups_of(place.clone());
        self.groups[groups].copy_from_slice(&done.groups);
        let aovs = self.aovs_of(&place);
        self.aovs[aovs].copy_from_slice(&done.aovs);
        if let Some(costs) = self.costs.get_mut(place.clone()) {
            costs.copy_from_slice(&done.costs);
        }
        if let Some(halves) = self.halves.get_mut(place.clone()) {
            halves.copy_from_slice(&done.halves);
        }
        if let Some(centers) = self.centers.get_mut(place) {
            centers.copy_from_slice(&done.centers);
        }
        self.clamped[row as usize] = done.clamped;
    }

    /// Where a row of it begins among the pixels of its region.
    pub fn first_of_row(&self, region: Region, row: usize) -> usize {
        let (column, top) = ((self.x - region.x0) as usize, (self.y - region.y0) as usize);
        (top + row) * region.width() as usize + column
    }

    /// Where the light groups of some pixels stand.
    pub fn groups_of(&self, pixels: Range<usize>) -> Range<usize> {
        let each = self.groups.len() / self.pixels.len().max(1);
        pixels.start * each..pixels.end * each
    }

    /// Where the sums of the scene's own passes of some pixels stand.
    pub fn aovs_of(&self, pixels: &Range<usize>) -> Range<usize> {
        let each = self.aovs.len() / self.pixels.len().max(1);
        pixels.start * each..pixels.end * each
    }

    fn place_of(&self, row: u32) -> Range<usize> {
        let width = self.width as usize;
        let start = row as usize * width;
        start..start + width
    }
}

/// Sums of a pixel's motion vectors.
pub fn vector_sums(passes: Passes) -> usize {
    if passes.has(Pass::Vector) {
        VECTOR_SUMS
    } else {
        0
    }
}

/// Sums of a pixel's shadow catchers, if there are any.
pub fn catcher_sums(catchers: bool) -> usize {
    if catchers { CATCHER_SUMS } else { 0 }
}

/// Those of the scene's own passes that a picture has.
pub fn shown(passes: Passes, aovs: &[Aov]) -> &[Aov] {
    if passes.has(Pass::Aov) { aovs } else { &[] }
}

/// What is kept of each pixel besides its sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Light apart.
    pub light_passes: bool,
    /// Features for denoisers.
    pub features: bool,
    /// Objects and mist.
    pub objects: bool,
    /// So many light groups.
    pub groups: usize,
    /// Floats of shadow catchers, of the scene's own passes and of motion vectors, in this order.
    pub aovs: usize,
    /// Time spent.
    pub costs: bool,
    /// Radiance of half of the samples.
    pub halves: bool,
    /// What the rays through the middles of pixels have met.
    pub centers: bool,
}

impl Kept {
    /// What passes need to be kept, so many light groups and the scene's own passes among them, shadow catchers, and a noise threshold,
    /// if there is one.
    pub fn of(
        passes: Passes,
        (groups, aovs, catchers): (usize, &[Aov], bool),
        has_threshold: bool,
    ) -> Self {
        Self {
            halves: has_threshold,
            light_passes: passes.need_light_passes(),
            features: passes.need_features(),
            objects: passes.need_objects(),
            groups,
            aovs: catcher_sums(catchers) + Aov::floats(shown(passes, aovs)) + vector_sums(passes),
            costs: passes.has(Pass::Cost),
            centers: false,
        }
    }

    /// What a render of a scene needs.
    pub fn of_render(settings: &RenderSettings, scene: &Scene) -> Self {
        let catchers = has_catchers(scene, settings);
        let own = (scene.light_groups.len(), &scene.aovs[..], catchers);
        Self {
            centers: settings.center_passes,
            ..Self::of(settings.passes, own, settings.noise_threshold.is_some())
        }
    }

    /// Bytes of a pixel that is kept so.
    pub fn bytes_a_pixel(self) -> usize {
        let of = |kept: bool, size: usize| if kept { size } else { 0 };
        size_of::<Pixel>()
            + of(self.light_passes, size_of::<PixelPasses>())
            + of(self.features, size_of::<PixelFeatures>())
            + of(self.objects, size_of::<PixelObjects>())
            + self.groups * size_of::<DVec3>()
            + self.aovs * size_of::<f64>()
            + of(self.costs, size_of::<u64>())
            + of(self.halves, size_of::<DVec3>())
            + of(self.centers, size_of::<Option<Option<Center>>>())
    }
}

/// Tiles of a region, row by row.
pub fn tiles(region: Region, kept: Kept) -> Vec<Mutex<Tile>> {
    let corners = (0..region.height().div_ceil(TILE))
        .flat_map(|ty| (0..region.width().div_ceil(TILE)).map(move |tx| (tx * TILE, ty * TILE)));
    corners
        .map(|(x, y)| {
            let (width, height) = (TILE.min(region.width() - x), TILE.min(region.height() - y));
            let pixels = (width * height) as usize;
            Mutex::new(Tile {
                x: region.x0 + x,
                y: region.y0 + y,
                width,
                height,
                pixels: vec![Pixel::default(); pixels],
                light_passes: vec![
                    PixelPasses::default();
                    if kept.light_passes { pixels } else { 0 }
                ],
                features: vec![PixelFeatures::default(); if kept.features { pixels } else { 0 }],
                objects: vec![PixelObjects::default(); if kept.objects { pixels } else { 0 }],
                groups: vec![DVec3::ZERO; kept.groups * pixels],
                aovs: vec![0.0; kept.aovs * pixels],
                costs: vec![0; if kept.costs { pixels } else { 0 }],
                halves: vec![DVec3::ZERO; if kept.halves { pixels } else { 0 }],
                centers: vec![None; if kept.centers { pixels } else { 0 }],
                errors: Vec::new(),
                deciding: Vec::new(),
                clamped: vec![[0.0; 2]; height as usize],
            })
        })
        .collect()
}

/// A thread that panicked left a tile as good as before: whole samples.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Tiles side by side.
pub fn across(region: Region) -> usize {
    region.width().div_ceil(TILE) as usize
}

/// A pixel's place among the tiles of its region: the tile's and its own within.
pub fn place(region: Region, column: u32, row: u32) -> (usize, usize) {
    let tile = (row / TILE) as usize * across(region) + (column / TILE) as usize;
    let width = TILE.min(region.width() - column / TILE * TILE);
    (tile, ((row % TILE) * width + column % TILE) as usize)
}

/// How many samples pixels have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples {
    /// Each of them, at least.
    pub least: u32,
    /// All together.
    pub all: u64,
    /// A pixel, the mean over the picture.
    pub mean: f64,
}

impl Samples {
    /// Of all pixels.
    pub fn of(tiles: &[Mutex<Tile>]) -> Self {
        let (mut least, mut all, mut pixels) = (None, 0u64, 0u64);
        for tile in tiles {
            for pixel in &locked(tile).pixels {
                least = Some(pixel.samples.min(least.unwrap_or(u32::MAX)));
                all += u64::from(pixel.samples);
                pixels += 1;
            }
        }
        Self {
            least: least.unwrap_or(0),
            all,
            mean: all as f64 / pixels.max(1) as f64,
        }
    }
}
