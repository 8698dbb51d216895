//! USD's shapes without points of their own, as polygons with smooth normals.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::polygons::{Interpolation, Layer, Polygons};
use super::source::View;
use crate::scene::{Diagnostics, Verdict};

/// The shapes that are made here.
pub(super) const KINDS: [&str; 8] = [
    "Sphere",
    "Cube",
    "Cylinder",
    "Cylinder_1",
    "Cone",
    "Capsule",
    "Capsule_1",
    "Plane",
];

/// What says how they are.
pub(super) const NUMBERS: [&str; 9] = [
    "radius",
    "height",
    "size",
    "width",
    "length",
    "axis",
    "radiusTop",
    "radiusBottom",
    "doubleSided",
];

/// Corners about an axis: what is round is off by 1 − cos(π/128), 0.03 % of its radius.
const AROUND: u32 = 128;
/// The same where there are very many: 0.5 %.
const AROUND_COARSE: u32 = 32;

/// A shape with normals, and coordinates once around and from bottom to top.
struct Builder {
    polygons: Polygons,
    normals: Vec<f32>,
    st: Vec<f32>,
    /// The axis of what is round: 0, 1, 2 for X, Y, Z.
    axis: usize,
    around: u32,
}

/// A place on a profile that is turned about the axis.
#[derive(Clone, Copy)]
struct Ring {
    radius: f64,
    height: f64,
    /// The normal, outwards and along the axis.
    normal: [f64; 2],
}

/// The straight side between the radii of both ends, half the height from the middle.
fn straight_side(bottom: f64, top: f64, half_height: f64) -> [Ring; 2] {
    let slope = glam::DVec2::new(2.0 * half_height, bottom - top).length();
    let normal = if slope > 0.0 {
        [2.0 * half_height / slope, (bottom - top) / slope]
    } else {
        [1.0, 0.0]
    };
    let ring = |radius, height| Ring {
        radius,
        height,
        normal,
    };
    [ring(bottom, -half_height), ring(top, half_height)]
}

impl Builder {
    fn new(axis: usize, around: u32) -> Self {
        Self {
            around,
            polygons: Polygons::new(Vec::new()),
            normals: Vec::new(),
            st: Vec::new(),
            axis,
        }
    }

    /// Axes turned so that Z becomes the shape's, right-handed.
    fn turned(&self, v: DVec3) -> DVec3 {
        match self.axis {
            0 => DVec3::new(v.z, v.x, v.y),
            1 => DVec3::new(v.y, v.z, v.x),
            _ => v,
        }
    }

    fn point(&mut self, at: DVec3, normal: DVec3, st: [f64; 2]) -> u32 {
        let (at, normal) = (self.turned(at), self.turned(normal));
        self.polygons.points.push(at.as_vec3().to_array());
        self.normals.extend(normal.as_vec3().to_array());
        self.st.extend(st.map(|v| v as f32));
        self.polygons.points.len() as u32 - 1
    }

    /// A profile, from below to above, turned about the axis.
    fn turn(&mut self, profile: &[Ring]) {
        let mut rows: Vec<Vec<u32>> = Vec::new();
        for (step, ring) in profile.iter().enumerate() {
            let v = step as f64 / (profile.len() - 1) as f64;
            let row = (0..=self.around).map(|i| {
                let u = f64::from(i) / f64::from(self.around);
                // The last one stands where the first one does, to the bit.
                let angle = if i == self.around { 0.0 } else { TAU * u };
                let (sin, cos) = angle.sin_cos();
                let at = DVec3::new(ring.radius * cos, ring.radius * sin, ring.height);
                let [out, up] = ring.normal;
                self.point(at, DVec3::new(out * cos, out * sin, up), [u, v])
            });
            rows.push(row.collect());
        }
        for (step, pair) in rows.windows(2).enumerate() {
            let [low, high] = pair else { continue };
            let closed = |at: usize| profile[at].radius == 0.0;
            for i in 0..self.around as usize {
                match (closed(step), closed(step + 1)) {
                    (true, true) => {}
                    (true, false) => self.polygons.face(&[low[i], high[i + 1], high[i]]),
                    (false, true) => self.polygons.face(&[low[i], low[i + 1], high[i]]),
                    (false, false) => {
                        self.polygons
                            .face(&[low[i], low[i + 1], high[i + 1], high[i]]);
                    }
                }
            }
        }
    }

    /// A flat end across the axis.
    fn lid(&mut self, radius: f64, height: f64, up: f64) {
        let normal = DVec3::Z * up;
        let mut ring: Vec<u32> = (0..self.around)
            .map(|i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(self.around)).sin_cos();
                let at = DVec3::new(radius * cos, radius * sin, height);
                self.point(at, normal, [0.5 + 0.5 * cos, 0.5 + 0.5 * sin])
            })
            .collect();
        if up < 0.0 {
            ring.reverse();
        }
        self.polygons.face(&ring);
    }

    /// A flat quad by its corners.
    fn quad(&mut self, corners: [DVec3; 4]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let normal = normal.normalize_or_zero();
        let st = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let ring = [0, 1, 2, 3].map(|i: usize| self.point(corners[i], normal, st[i]));
        self.polygons.face(&ring);
    }

    fn done(self) -> Polygons {
        let layer = |components, values| Layer {
            components,
            values,
            interpolation: Interpolation::Vertex,
            indices: None,
        };
        let mut polygons = self.polygons;
        polygons.normals = Some(layer(3, self.normals));
        polygons.primvars.insert("st".into(), layer(2, self.st));
        polygons
    }
}

/// An arc of a profile about a height, from an angle below the horizon to one above it.
fn arc(rings: u32, radius: f64, height: f64, from: f64, to: f64) -> Vec<Ring> {
    let ring = |step: u32| {
        let angle = from + (to - from) * f64::from(step) / f64::from(rings);
        let (sin, cos) = angle.sin_cos();
        // Poles are on the axis, exactly.
        let cos = if (angle.abs() - 0.5 * PI).abs() < 1e-12 {
            0.0
        } else {
            cos
        };
        Ring {
            radius: radius * cos,
            height: height + radius * sin,
            normal: [cos, sin],
        }
    };
    (0..=rings).map(ring).collect()
}

/// The polygons of a shape.
pub(super) fn polygons(
    prim: &View,
    kind: &str,
    fine: bool,
    diagnostics: &mut Diagnostics,
) -> Option<Polygons> {
    let around = if fine { AROUND } else { AROUND_COARSE };
    let rings = around / 2;
    let number = |name: &str, fallback: f64| prim.number(name).unwrap_or(fallback);
    let axis = match prim.word("axis").as_deref() {
        Some("X") => 0,
        Some("Y") => 1,
        _ => 2,
    };
    let mut builder = Builder::new(axis, around);
    let half = 0.5 * PI;
    match kind {
        "Sphere" => {
            builder.axis = 2;
            builder.turn(&arc(rings, number("radius", 1.0), 0.0, -half, half));
        }
        "Cube" => {
            builder.axis = 2;
            let h = 0.5 * number("size", 2.0);
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut side = DVec3::ZERO;
                    side[axis] = sign * h;
                    let mut u = DVec3::ZERO;
                    u[(axis + 1) % 3] = h;
                    let mut v = DVec3::ZERO;
                    v[(axis + 2) % 3] = h * sign;
                    builder.quad([side - u - v, side + u - v, side + u + v, side - u + v]);
                }
            }
        }
        "Plane" => {
            let (x, y) = (0.5 * number("width", 2.0), 0.5 * number("length", 2.0));
            // For an axis X its width is along Z; for Y along X.
            let (x, y) = if axis < 2 { (y, x) } else { (x, y) };
            let corner = |a: f64, b: f64| DVec3::new(a * x, b * y, 0.0);
            builder.quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]);
        }
        "Cone" => {
            let (r, h) = (number("radius", 1.0), 0.5 * number("height", 2.0));
            builder.turn(&straight_side(r, 0.0, h));
            builder.lid(r, -h, -1.0);
        }
        "Cylinder" | "Cylinder_1" | "Capsule" | "Capsule_1" => {
            let capsule = kind.starts_with("Capsule");
            let (r, h) = if capsule {
                (number("radius", 0.5), 0.5 * number("height", 1.0))
            } else {
                (number("radius", 1.0), 0.5 * number("height", 2.0))
            };
            let bottom = number("radiusBottom", r);
            let top = number("radiusTop", r);
            if capsule && bottom != top {
                diagnostics.report(
                    "usd-capsule",
                    Verdict::Approximated,
                    "capsules with ends of two sizes",
                    prim.path().to_string(),
                    "the ends meet the side at their widest",
                );
            }
            if capsule {
                builder.turn(&arc(rings, bottom, -h, -half, 0.0));
                builder.turn(&arc(rings, top, h, 0.0, half));
            } else {
                builder.lid(bottom, -h, -1.0);
                builder.lid(top, h, 1.0);
            }
            builder.turn(&straight_side(bottom, top, h));
        }
        _ => return None,
    }
    Some(builder.done())
}

/// Points, normals and triangles.
pub(super) type Tube = (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[u32; 3]>);

/// The side of a cylinder along X.
pub(super) fn tube(radius: f64, length: f64) -> Tube {
    let mut builder = Builder::new(0, AROUND);
    let ring = |height| Ring {
        radius,
        height,
        normal: [1.0, 0.0],
    };
    builder.turn(&[ring(-0.5 * length), ring(0.5 * length)]);
    let (normals, _) = builder.normals.as_chunks::<3>();
    let (quads, _) = builder.polygons.corners.as_chunks::<4>();
    let triangles = quads
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    (
        builder.polygons.points,
        normals.to_vec(),
        triangles.collect(),
    )
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/primitives.rs"]
mod tests;
