//! From the sums of the pixels to the passes of a picture.

use super::Region;
use super::schedule::{TILE, Tile, locked};
use crate::film::apart::PixelApart;
use crate::film::pixel::Pixel;
use crate::film::{Bands, Pass, Passes};
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Range;
use std::sync::Mutex;

/// Blender's axes (Z up) from Sundog's (Y up).
fn blender_axes(v: DVec3) -> [f32; 3] {
    [v.x as f32, -v.z as f32, v.y as f32]
}

/// The pixels so far, as a picture.
pub struct Film<'a> {
    tiles: &'a [Mutex<Tile>],
    region: Region,
    passes: Passes,
    /// The camera's axes as Cycles has them: it looks along +Z.
    axes: DMat3,
}

impl<'a> Film<'a> {
    /// The passes of a region that these tiles, row by row, make up.
    pub fn new(
        world_from_camera: &DAffine3,
        region: Region,
        tiles: &'a [Mutex<Tile>],
        passes: Passes,
    ) -> Self {
        let m = &world_from_camera.matrix3;
        Self {
            tiles,
            region,
            passes,
            axes: DMat3::from_cols(
                m.x_axis.normalize_or_zero(),
                m.y_axis.normalize_or_zero(),
                -m.z_axis.normalize_or_zero(),
            ),
        }
    }

    /// What it is made of.
    pub fn tiles(&self) -> &'a [Mutex<Tile>] {
        self.tiles
    }

    /// With other passes.
    pub fn with(&self, passes: Passes) -> Self {
        Self { passes, ..*self }
    }

    /// Tiles side by side.
    fn across(&self) -> usize {
        self.region.width().div_ceil(TILE) as usize
    }
}

impl Bands for Film<'_> {
    fn size(&self) -> (u32, u32) {
        (self.region.width(), self.region.height())
    }

    fn layers(&self) -> Vec<(String, String)> {
        let passes = self.passes.iter();
        passes
            .map(|pass| (pass.name().into(), pass.channels().into()))
            .collect()
    }

    fn bands(&self) -> Vec<Range<u32>> {
        let height = self.region.height();
        let starts = (0..height).step_by(TILE as usize);
        starts.map(|from| from..(from + TILE).min(height)).collect()
    }

    fn fill(&self, band: usize, layers: &mut [&mut [f32]]) {
        let passes: Vec<Pass> = self.passes.iter().collect();
        let width = self.region.width() as usize;
        for tile in self.tiles.chunks(self.across()).nth(band).unwrap_or(&[]) {
            let tile = locked(tile);
            for (i, pixel) in tile.pixels.iter().enumerate() {
                let (column, row) = (i as u32 % tile.width, i as u32 / tile.width);
                let at = row as usize * width + (tile.x - self.region.x0 + column) as usize;
                let nothing = PixelApart::default();
                let apart = tile.apart.get(i).unwrap_or(&nothing);
                for (&pass, layer) in passes.iter().zip(layers.iter_mut()) {
                    let n = pass.channels().len();
                    let place = &mut layer[at * n..][..n];
                    match value(pixel, apart, pass, &self.axes) {
                        Value::One(v) => place[0] = v,
                        Value::Three(v) => place.copy_from_slice(&v),
                        Value::Four(v) => place.copy_from_slice(&v),
                    }
                }
            }
        }
    }
}

enum Value {
    One(f32),
    Three([f32; 3]),
    Four([f32; 4]),
}

#[inline]
fn value(p: &Pixel, apart: &PixelApart, pass: Pass, axes: &DMat3) -> Value {
    let scale = if p.samples > 0 {
        1.0 / f64::from(p.samples)
    } else {
        0.0
    };
    let color = |v: DVec3| Value::Three(v.as_vec3().to_array());
    match pass {
        Pass::Combined => {
            let [r, g, b] = (p.radiance * scale).as_vec3().to_array();
            // Exactly 1 where every sample is part of the picture.
            let alpha = 1.0 - f64::from(p.transparent) * scale;
            Value::Four([r, g, b, alpha as f32])
        }
        Pass::Depth => Value::One(p.middle.depth),
        Pass::Normal => Value::Three(blender_axes(p.normal * scale)),
        Pass::Position => Value::Three(blender_axes(p.middle.position.as_dvec3())),
        Pass::Uv => Value::Three(apart.uv(scale)),
        Pass::DiffuseDirect => color(apart.light(0, false)),
        Pass::DiffuseIndirect => color(apart.light(0, true)),
        Pass::DiffuseColor => color(apart.color(0, scale)),
        Pass::GlossyDirect => color(apart.light(1, false)),
        Pass::GlossyIndirect => color(apart.light(1, true)),
        Pass::GlossyColor => color(apart.color(1, scale)),
        Pass::TransmissionDirect => color(apart.light(2, false)),
        Pass::TransmissionIndirect => color(apart.light(2, true)),
        Pass::TransmissionColor => color(apart.color(2, scale)),
        Pass::Emission => color(apart.emission(scale)),
        Pass::Environment => color(apart.environment(scale)),
        Pass::DenoisingAlbedo => color(p.albedo * scale),
        Pass::DenoisingNormal => color(axes.transpose() * (p.normal * scale)),
        Pass::SampleCount => Value::One(p.samples as f32),
    }
}
