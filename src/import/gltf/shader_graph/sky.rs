//! Sky textures: a table that the add-on has asked Blender for, and the disc of the sun.

use super::{NodeJson, Reader, Refusal, Stop};
use crate::nodes::sky::{Sky, SunCone, SunDisc};
use crate::scene::Pixels;
use crate::scene::graph::{Function, Input, NodeKind};
use glam::Vec3;
use serde::Deserialize;
use std::sync::Arc;

/// The property `sky`.
#[derive(Debug, Deserialize)]
struct SkyJson {
    image: ImageJson,
    start: f32,
    sun: Option<SunJson>,
    sought: Option<SoughtJson>,
}

#[derive(Debug, Deserialize)]
struct ImageJson {
    index: usize,
}

#[derive(Debug, Deserialize)]
struct SunJson {
    direction: [f32; 3],
    half_angle: f32,
    elevations: [f32; 2],
    colors: [[f32; 3]; 2],
    horizon: f32,
    #[serde(default)]
    covers: bool,
}

#[derive(Debug, Deserialize)]
struct SoughtJson {
    direction: [f32; 3],
    half_angle: f32,
}

impl SoughtJson {
    fn cone(&self) -> Option<SunCone> {
        let is_there = self.half_angle.is_finite() && self.half_angle > 0.0;
        Some(SunCone {
            direction: is_there
                .then_some(Vec3::from(self.direction))?
                .try_normalize()?,
            half_angle: self.half_angle,
        })
    }
}

impl SunJson {
    /// The disc, if it has one.
    fn disc(&self) -> Option<SunDisc> {
        let [low, high] = self.elevations;
        let numbers = self.colors.as_flattened().iter();
        let is_known = numbers.chain(&self.elevations).all(|v| v.is_finite());
        let is_there = self.half_angle.is_finite() && self.half_angle > 0.0 && low < high;
        (is_known && is_there && self.horizon.is_finite()).then_some(())?;
        Some(SunDisc {
            direction: Vec3::from(self.direction).try_normalize()?,
            half_angle: self.half_angle,
            elevations: self.elevations,
            colors: self.colors.map(Vec3::from),
            horizon: self.horizon,
            covers: self.covers,
        })
    }
}

impl Reader<'_, '_, '_> {
    pub(super) fn sky(&mut self, at: usize) -> Result<Input, Stop> {
        let node = &self.source.nodes[at];
        let table = node.properties.get("sky");
        let Some(Ok(json)) = table.map(SkyJson::deserialize) else {
            return Err(Refusal::of(node, "without a table").into());
        };
        let image = self.images.decoded(json.image.index, self.owner)?;
        let image = image.map_err(|reason| Refusal::of(node, &reason))?;
        let sky = sky(node, &json, &image)?;
        let function = Function::Sky(Arc::new(sky));
        Ok(self.add(at, NodeKind::Function(function), &[]).into())
    }
}

fn sky(node: &NodeJson, json: &SkyJson, image: &crate::scene::Image) -> Result<Sky, Refusal> {
    let refused = || Refusal::of(node, "a table that is not one of three floats a texel");
    let Pixels::F32(values) = &image.pixels else {
        return Err(refused());
    };
    let channels = image.channels as usize;
    if channels < 3 || image.width == 0 || image.height == 0 || !json.start.is_finite() {
        return Err(refused());
    }
    let color = |texel: &[f32]| {
        let color = Vec3::from_slice(texel);
        Vec3::select(color.cmpge(Vec3::ZERO), color, Vec3::ZERO).min(Vec3::splat(f32::MAX))
    };
    Ok(Sky {
        width: image.width as usize,
        height: image.height as usize,
        texels: values.chunks_exact(channels).map(color).collect(),
        start: json.start,
        sun: json.sun.as_ref().and_then(SunJson::disc),
        sought: json.sought.as_ref().and_then(SoughtJson::cone),
    })
}
