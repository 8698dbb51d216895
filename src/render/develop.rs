//! From the sums of the pixels to the passes of a picture.

use super::Region;
use super::schedule::{Tile, locked};
use crate::film::pixel::Pixel;
use crate::film::{Layer, Pass, Passes, Picture};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use std::sync::Mutex;

/// Blender's axes (Z up) from Sundog's (Y up).
fn blender_axes(v: DVec3) -> [f32; 3] {
    [v.x as f32, -v.z as f32, v.y as f32]
}

/// The region's picture with these passes; bands of tiles side by side on the threads of the pool.
pub fn develop(
    world_from_camera: &DAffine3,
    region: Region,
    tiles: &[Mutex<Tile>],
    passes: Passes,
) -> Picture {
    let (width, height) = (region.width(), region.height());
    let size = width as usize * height as usize;
    let axes = DMat3::from_cols(
        world_from_camera.matrix3.x_axis.normalize_or_zero(),
        world_from_camera.matrix3.y_axis.normalize_or_zero(),
        // Cycles' cameras look along +Z.
        -world_from_camera.matrix3.z_axis.normalize_or_zero(),
    );
    let layers = passes
        .iter()
        .map(|pass| Layer {
            name: pass.name().into(),
            channels: pass.channels().chars().map(String::from).collect(),
            data: vec![0.0; size * pass.channels().len()],
        })
        .collect();
    let mut picture = Picture {
        width,
        height,
        layers,
    };
    let across = tiles
        .iter()
        .position(|tile| locked(tile).y != region.y0)
        .unwrap_or(tiles.len())
        .max(1);
    for (layer, pass) in picture.layers.iter_mut().zip(passes.iter()) {
        let row = width as usize * layer.channels.len();
        // All tiles of a band are as high as its first.
        let mut bands = Vec::new();
        let mut rest = layer.data.as_mut_slice();
        for band in tiles.chunks(across) {
            let high = band.first().map_or(0, |tile| locked(tile).height);
            let (part, after) = rest.split_at_mut(row * high as usize);
            bands.push((band, part));
            rest = after;
        }
        bands.into_par_iter().for_each(|(band, part)| {
            for tile in band {
                let tile = locked(tile);
                fill(&tile, pass, &axes, tile.x - region.x0, row, part);
            }
        });
    }
    picture
}

/// Writes a tile's values of a pass into rows of `row` floats, from column `x` on.
fn fill(tile: &Tile, pass: Pass, axes: &DMat3, x: u32, row: usize, part: &mut [f32]) {
    let n = pass.channels().len();
    for (i, pixel) in tile.pixels.iter().enumerate() {
        let (column, line) = (i as u32 % tile.width, i as u32 / tile.width);
        let at = line as usize * row + (x + column) as usize * n;
        let place = &mut part[at..at + n];
        match value(tile, i, pixel, pass, axes) {
            Value::One(v) => place[0] = v,
            Value::Three(v) => place.copy_from_slice(&v),
            Value::Four(v) => place.copy_from_slice(&v),
        }
    }
}

enum Value {
    One(f32),
    Three([f32; 3]),
    Four([f32; 4]),
}

#[inline]
fn value(tile: &Tile, index: usize, p: &Pixel, pass: Pass, axes: &DMat3) -> Value {
    let scale = if p.samples > 0 {
        1.0 / f64::from(p.samples)
    } else {
        0.0
    };
    let color = |v: DVec3| Value::Three(v.as_vec3().to_array());
    let apart = || tile.apart.get(index).copied().unwrap_or_default();
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
        Pass::Uv => Value::Three(apart().uv(scale)),
        Pass::DiffuseDirect => color(apart().light(0, false)),
        Pass::DiffuseIndirect => color(apart().light(0, true)),
        Pass::DiffuseColor => color(apart().color(0, scale)),
        Pass::GlossyDirect => color(apart().light(1, false)),
        Pass::GlossyIndirect => color(apart().light(1, true)),
        Pass::GlossyColor => color(apart().color(1, scale)),
        Pass::TransmissionDirect => color(apart().light(2, false)),
        Pass::TransmissionIndirect => color(apart().light(2, true)),
        Pass::TransmissionColor => color(apart().color(2, scale)),
        Pass::Emission => color(apart().emission(scale)),
        Pass::Environment => color(apart().environment(scale)),
        Pass::DenoisingAlbedo => color(p.albedo * scale),
        Pass::DenoisingNormal => color(axes.transpose() * (p.normal * scale)),
        Pass::SampleCount => Value::One(p.samples as f32),
    }
}
