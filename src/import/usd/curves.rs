//! BasisCurves become tubes, or ribbons where they have normals.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::polygons::{Interpolation, Layer, Polygons};
use super::source::View;
use super::value;
use crate::scene::{Diagnostics, Verdict};

/// Steps of a cubic segment, and corners about a tube, for so many rings at most.
const FINENESS: [(usize, usize, usize); 4] = [
    (20_000, 8, 16),
    (200_000, 8, 8),
    (1_000_000, 4, 6),
    (usize::MAX, 4, 4),
];

/// The bases of cubic curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basis {
    Linear,
    Bezier,
    BSpline,
    CatmullRom,
}

/// How curves end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrap {
    Open,
    /// They go back to where they began.
    Closed,
    /// They reach their first and last points.
    Pinned,
}

/// A place on a curve, by the values that count there.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    curve: u32,
    /// Control points and their shares; more than four where ends are continued.
    points: [(u32, f64); 6],
    /// Values at the ends of segments and their shares.
    ends: [(u32, f64); 2],
}

/// Curves as they stand in the file.
struct Curves {
    basis: Basis,
    wrap: Wrap,
    counts: Vec<usize>,
    points: Vec<[f32; 3]>,
}

/// Where the points of the tubes lie on the curves that they are made of.
pub(super) struct Strands {
    samples: Vec<Sample>,
    /// The sample of each point.
    of_point: Vec<u32>,
    /// Curves, control points, ends of segments.
    counts: [usize; 3],
}

impl Curves {
    fn read(prim: &View) -> Option<Self> {
        let points = prim.value("points").as_ref().and_then(value::points)?;
        let counts = prim.integers("curveVertexCounts")?;
        let linear = prim.word("type").as_deref() == Some("linear");
        let basis = match prim.word("basis").as_deref() {
            _ if linear => Basis::Linear,
            Some("bspline") => Basis::BSpline,
            Some("catmullRom") => Basis::CatmullRom,
            _ => Basis::Bezier,
        };
        let wrap = match prim.word("wrap").as_deref() {
            Some("periodic") => Wrap::Closed,
            // The others reach their ends anyway.
            Some("pinned") if matches!(basis, Basis::BSpline | Basis::CatmullRom) => Wrap::Pinned,
            _ => Wrap::Open,
        };
        let counts = counts.iter().map(|c| usize::try_from(*c).unwrap_or(0));
        Some(Self {
            basis,
            wrap,
            counts: counts.collect(),
            points,
        })
    }

    /// Segments of a curve of so many points.
    fn segments(&self, count: usize) -> usize {
        match (self.basis, self.wrap) {
            (Basis::Linear, Wrap::Closed) if count > 2 => count,
            (Basis::Linear, _) => count.saturating_sub(1),
            (Basis::Bezier, Wrap::Closed) => count / 3,
            (Basis::Bezier, _) if count >= 4 => (count - 4) / 3 + 1,
            (Basis::Bezier, _) => 0,
            (_, Wrap::Closed) if count >= 3 => count,
            (_, Wrap::Closed) => 0,
            (_, Wrap::Pinned) => count.saturating_sub(1),
            (_, Wrap::Open) => count.saturating_sub(3),
        }
    }

    /// The place at `t` of a segment.
    fn sample(
        &self,
        (curve, start, ends): (usize, usize, usize),
        (segment, segments): (usize, usize),
        t: f64,
    ) -> Sample {
        let count = self.counts[curve];
        let mut points = [(start as u32, 0.0); 6];
        let id = |at: usize| (start + at % count) as u32;
        if self.basis == Basis::Linear {
            points[0] = (id(segment), 1.0 - t);
            points[1] = (id(segment + 1), t);
        } else {
            let step = if self.basis == Basis::Bezier { 3 } else { 1 };
            let first = (segment * step) as isize - isize::from(self.wrap == Wrap::Pinned);
            let mut next = 0;
            let mut put = |at: usize, share: f64| {
                if let Some(place) = points.get_mut(next) {
                    *place = (id(at), share);
                }
                next += 1;
            };
            for (at, share) in (first..).zip(self.basis.shares(t)) {
                let last = count as isize - 1;
                match at {
                    // A point beyond an end continues the line through the two before it.
                    -1 => {
                        put(0, 2.0 * share);
                        put(1, -share);
                    }
                    at if at > last && self.wrap == Wrap::Pinned => {
                        put(count - 1, 2.0 * share);
                        put(count - 2, -share);
                    }
                    at => put(at as usize, share),
                }
            }
        }
        let turns = self.wrap == Wrap::Closed;
        let after = if turns {
            (segment + 1) % segments
        } else {
            segment + 1
        };
        Sample {
            curve: curve as u32,
            points,
            ends: [
                ((ends + segment) as u32, 1.0 - t),
                ((ends + after) as u32, t),
            ],
        }
    }
}

impl Basis {
    /// Shares of the four points of a segment.
    fn shares(self, t: f64) -> [f64; 4] {
        let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
        match self {
            Self::Linear => [s, t, 0.0, 0.0],
            Self::Bezier => [s * s * s, 3.0 * s * s * t, 3.0 * s * t2, t3],
            Self::BSpline => [
                s * s * s / 6.0,
                (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
                (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
                t3 / 6.0,
            ],
            Self::CatmullRom => [
                0.5 * (-t3 + 2.0 * t2 - t),
                0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
                0.5 * (-3.0 * t3 + 4.0 * t2 + t),
                0.5 * (t3 - t2),
            ],
        }
    }
}

/// The tubes or ribbons of a prim, and where their points lie; `None` for one without curves.
pub(super) fn polygons(
    prim: &View,
    corners: impl FnOnce(u64) -> bool,
    diagnostics: &mut Diagnostics,
) -> Option<(Polygons, Strands)> {
    let curves = Curves::read(prim)?;
    let mut report = |verdict, what: &str, instead: &str| {
        diagnostics.report(
            "usd-curves",
            verdict,
            what,
            prim.path().to_string(),
            instead,
        );
    };
    let rings = |steps: usize| -> usize {
        let segments = curves.counts.iter().map(|c| curves.segments(*c));
        segments
            .map(|s| s.saturating_mul(steps).saturating_add(1))
            .fold(0, usize::saturating_add)
    };
    let linear = curves.basis == Basis::Linear;
    let most = FINENESS
        .iter()
        .find(|(most, steps, _)| rings(*steps) <= *most);
    let (_, steps, around) = *most?;
    let steps = if linear { 1 } else { steps };
    let (mut strands, starts) = strands(&curves, steps);
    if starts.is_empty() {
        report(Verdict::Lost, "curves without a segment", "left out");
        return None;
    }
    let normals = value_layer(prim, &["primvars:normals", "normals"], 3, &strands);
    let around = if normals.is_some() { 1 } else { around };
    if !corners((strands.samples.len() as u64).saturating_mul(4 * around as u64)) {
        report(
            Verdict::Lost,
            "curves that take too much memory",
            "left out",
        );
        return None;
    }
    let widths = value_layer(prim, &["widths", "primvars:widths"], 1, &strands);
    if widths.is_none() {
        report(
            Verdict::Approximated,
            "curves without widths",
            "they are one unit wide",
        );
    }
    let radii: Vec<f64> = match &widths {
        Some(widths) => widths.iter().map(|w| (0.5 * w[0]).max(0.0)).collect(),
        None => vec![0.5; strands.samples.len()],
    };
    let middles: Vec<DVec3> = strands
        .samples
        .iter()
        .map(|sample| {
            let sum = sample.points.iter().map(|(at, share)| {
                let point = curves.points.get(*at as usize).copied().unwrap_or_default();
                *share * DVec3::from(point.map(f64::from))
            });
            sum.sum()
        })
        .collect();
    let mut builder = Builder {
        polygons: Polygons::new(Vec::new()),
        normals: Vec::new(),
        of_point: Vec::new(),
        around,
    };
    let closed = curves.wrap == Wrap::Closed;
    for (start, count) in starts {
        let range = start..start + count;
        let (middles, radii) = (&middles[range.clone()], &radii[range.clone()]);
        match &normals {
            Some(normals) => builder.ribbon(start, middles, radii, &normals[range], closed),
            None => builder.tube(start, middles, radii, closed),
        }
    }
    let what = if normals.is_some() {
        "ribbons"
    } else {
        "tubes"
    };
    let corners = if normals.is_some() {
        String::new()
    } else {
        format!(" of {around} sides")
    };
    report(
        Verdict::Approximated,
        "curves",
        &format!("rendered as {what}{corners}, as wide as they are on the mean"),
    );
    strands.of_point = builder.of_point;
    let mut polygons = builder.polygons;
    polygons.normals = Some(Layer {
        components: 3,
        values: builder.normals,
        interpolation: Interpolation::Vertex,
        indices: None,
    });
    Some((polygons, strands))
}

/// Samples of all curves, and where those of each begin and how many there are.
fn strands(curves: &Curves, steps: usize) -> (Strands, Vec<(usize, usize)>) {
    let mut samples = Vec::new();
    let mut starts = Vec::new();
    let (mut start, mut ends) = (0usize, 0);
    for (curve, count) in curves.counts.iter().copied().enumerate() {
        let segments = curves.segments(count);
        let whole = start
            .checked_add(count)
            .is_some_and(|end| end <= curves.points.len());
        if segments > 0 && whole {
            let first = samples.len();
            for segment in 0..segments {
                for step in 0..steps {
                    let t = step as f64 / steps as f64;
                    samples.push(curves.sample((curve, start, ends), (segment, segments), t));
                }
            }
            if curves.wrap != Wrap::Closed {
                let last = (segments - 1, segments);
                samples.push(curves.sample((curve, start, ends), last, 1.0));
            }
            starts.push((first, samples.len() - first));
        }
        start = start.saturating_add(count);
        ends += segments + usize::from(curves.wrap != Wrap::Closed);
    }
    let counts = [curves.counts.len(), curves.points.len(), ends];
    let of_point = Vec::new();
    (
        Strands {
            samples,
            of_point,
            counts,
        },
        starts,
    )
}

/// Values of the first of some attributes that is there, at all samples.
fn value_layer(
    prim: &View,
    names: &[&str],
    components: usize,
    strands: &Strands,
) -> Option<Vec<[f64; 3]>> {
    let name = names.iter().find(|name| prim.value(name).is_some())?;
    let (found, values) = strands.values(prim, name, Interpolation::Vertex)?;
    (found == components)
        .then_some(values)?
        .chunks(components)
        .map(|value| {
            let at = |i: usize| value.get(i).copied().map_or(0.0, f64::from);
            Some([at(0), at(1), at(2)])
        })
        .collect()
}

impl Strands {
    /// Values of an attribute at all samples, one after the other, and how many numbers each has.
    fn values(
        &self,
        prim: &View,
        name: &str,
        fallback: Interpolation,
    ) -> Option<(usize, Vec<f32>)> {
        let (components, plain) = value::floats(&prim.value(name)?)?;
        let indices = prim.integers(&format!("{name}:indices"));
        let held = plain.len() / components.max(1);
        let there = indices.as_ref().map_or(held, Vec::len);
        let [curves, points, ends] = self.counts;
        let told = match prim.property_word(name, "interpolation").as_deref() {
            Some("constant") => Interpolation::Constant,
            Some("uniform") => Interpolation::Uniform,
            Some("varying" | "faceVarying") => Interpolation::FaceVarying,
            Some("vertex") => Interpolation::Vertex,
            _ => fallback,
        };
        let of = |kind| match kind {
            Interpolation::Constant => 1,
            Interpolation::Uniform => curves,
            Interpolation::Vertex => points,
            Interpolation::FaceVarying => ends,
        };
        // What does not fit is taken for what it fits.
        let kind = if there == of(told) {
            told
        } else {
            let all = [
                Interpolation::Vertex,
                Interpolation::FaceVarying,
                Interpolation::Uniform,
            ];
            let fitting = all.into_iter().find(|kind| of(*kind) == there);
            fitting.unwrap_or(Interpolation::Constant)
        };
        let at = |place: u32, component: usize| -> f64 {
            let place = match &indices {
                Some(indices) => indices
                    .get(place as usize)
                    .and_then(|i| usize::try_from(*i).ok()),
                None => Some(place as usize),
            };
            let value = place.and_then(|place| plain.get(place * components + component));
            value.copied().map_or(0.0, f64::from)
        };
        if there == 0 {
            return None;
        }
        let mut all = Vec::with_capacity(self.samples.len() * components);
        for sample in &self.samples {
            for component in 0..components {
                let value: f64 = match kind {
                    Interpolation::Constant => at(0, component),
                    Interpolation::Uniform => at(sample.curve, component),
                    Interpolation::Vertex => {
                        let shares = sample.points.iter().filter(|(_, share)| *share != 0.0);
                        shares
                            .map(|(place, share)| share * at(*place, component))
                            .sum()
                    }
                    Interpolation::FaceVarying => {
                        let shares = sample.ends.iter().filter(|(_, share)| *share != 0.0);
                        shares
                            .map(|(place, share)| share * at(*place, component))
                            .sum()
                    }
                };
                all.push(value as f32);
            }
        }
        Some((components, all))
    }

    /// A primvar of the curves on the points of their tubes.
    pub(super) fn layer(&self, prim: &View, name: &str) -> Option<Layer> {
        let (components, values) = self.values(prim, name, Interpolation::Constant)?;
        let of = |sample: &u32| {
            let start = *sample as usize * components;
            values[start..start + components].iter().copied()
        };
        Some(Layer {
            components,
            values: self.of_point.iter().flat_map(of).collect(),
            interpolation: Interpolation::Vertex,
            indices: None,
        })
    }
}

/// Polygons along curves.
struct Builder {
    polygons: Polygons,
    normals: Vec<f32>,
    of_point: Vec<u32>,
    around: usize,
}

/// Directions along a line of points.
fn tangents(middles: &[DVec3], closed: bool) -> Vec<DVec3> {
    let count = middles.len();
    let mut last = DVec3::Z;
    let tangent = |at: usize| {
        let (before, after) = if closed {
            ((at + count - 1) % count, (at + 1) % count)
        } else {
            (at.saturating_sub(1), (at + 1).min(count - 1))
        };
        last = (middles[after] - middles[before]).normalize_or(last);
        last
    };
    (0..count).map(tangent).collect()
}

impl Builder {
    fn point(&mut self, at: DVec3, normal: DVec3, sample: usize) -> u32 {
        self.polygons.points.push(at.as_vec3().to_array());
        self.normals.extend(normal.as_vec3().to_array());
        self.of_point.push(sample as u32);
        self.polygons.points.len() as u32 - 1
    }

    fn tube(&mut self, first: usize, middles: &[DVec3], radii: &[f64], closed: bool) {
        let count = middles.len();
        let along = tangents(middles, closed);
        // Carried along without a turn about the curve.
        let mut side = along[0].any_orthogonal_vector().normalize_or(DVec3::X);
        let mut sides = Vec::with_capacity(count);
        let carried = |side: DVec3, along: DVec3| {
            (side - along * along.dot(side)).normalize_or(along.any_orthogonal_vector())
        };
        for direction in &along {
            side = carried(side, *direction);
            sides.push(side);
        }
        // What a closed one is turned by when it is back, each ring takes its share of.
        let twist = if closed {
            let back = carried(side, along[0]);
            let up = along[0].cross(sides[0]);
            back.dot(up).atan2(back.dot(sides[0]))
        } else {
            0.0
        };
        // A polygon's width is on the mean that of a circle as long as it.
        let corner = PI / self.around as f64;
        let wider = corner / corner.sin();
        let mut rings: Vec<Vec<u32>> = Vec::with_capacity(count);
        for at in 0..count {
            let up = along[at].cross(sides[at]);
            let turn = -twist * at as f64 / count as f64;
            let ring = (0..self.around).map(|i| {
                let (sin, cos) = (turn + TAU * i as f64 / self.around as f64).sin_cos();
                let out = sides[at] * cos + up * sin;
                self.point(middles[at] + out * (radii[at] * wider), out, first + at)
            });
            let ring = ring.collect();
            rings.push(ring);
        }
        let steps = if closed { count } else { count - 1 };
        for at in 0..steps {
            let (low, high) = (&rings[at], &rings[(at + 1) % count]);
            for i in 0..self.around {
                let next = (i + 1) % self.around;
                self.polygons
                    .face(&[low[i], low[next], high[next], high[i]]);
            }
        }
        if !closed {
            self.lid(&rings[0], -along[0], (first, true));
            self.lid(
                &rings[count - 1],
                along[count - 1],
                (first + count - 1, false),
            );
        }
    }

    /// A flat end; that of the beginning is seen from the other side.
    fn lid(&mut self, ring: &[u32], out: DVec3, (sample, begins): (usize, bool)) {
        let mut own = Vec::with_capacity(ring.len());
        for point in ring {
            let at = DVec3::from(self.polygons.points[*point as usize].map(f64::from));
            own.push(self.point(at, out, sample));
        }
        if begins {
            own.reverse();
        }
        self.polygons.face(&own);
    }

    fn ribbon(
        &mut self,
        first: usize,
        middles: &[DVec3],
        radii: &[f64],
        normals: &[[f64; 3]],
        closed: bool,
    ) {
        let count = middles.len();
        let along = tangents(middles, closed);
        let edges: Vec<[u32; 2]> = (0..count)
            .map(|at| {
                let normal = DVec3::from(normals[at]);
                let side = normal.cross(along[at]);
                let side = side.normalize_or(along[at].any_orthogonal_vector());
                let normal = along[at].cross(side).normalize_or(DVec3::Z);
                [-radii[at], radii[at]]
                    .map(|r| self.point(middles[at] + side * r, normal, first + at))
            })
            .collect();
        let steps = if closed { count } else { count - 1 };
        for at in 0..steps {
            let ([a, b], [d, c]) = (edges[at], edges[(at + 1) % count]);
            self.polygons.face(&[a, b, c, d]);
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/curves.rs"]
mod tests;
