//! Strands and points in the layout that Embree reads in place: curves with a radius, and spheres.

use super::{EmbreeError, Scene, check_steps, sys};
use glam::{Vec3, Vec4};
use std::mem::size_of;
use std::sync::Arc;

/// Steps in which a `v` tells how far a normal leans along the strand: a unit of them is this much of `v`, whose own part is less than
/// half of it …
const LEAN: f32 = 8.0;
/// … and so many of them are a right angle's sine. With 2¹¹ in all a float has 13 bits left for what lies across.
const LEANS: f32 = 256.0;

/// What strands look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrandShape {
    /// Flat, towards each ray, but shaded as if they were round: so many pieces for each segment.
    Ribbon(u8),
    /// Round about Catmull-Rom curves.
    Round,
    /// Round about straight segments.
    RoundLinear,
    /// Spheres.
    Points,
}

/// Curves of keys, or points. Hits are numbered by segment or point.
///
/// Where a hit lies across a strand stands in its `v`, by which [`StrandMesh::around`] finds the rounded normal: from the middle (0)
/// to the sides (−1, 1), and from there to the middle of the far side, which rays meet from within (−2, 2); how far it leans along the strand is
/// packed with it ([`StrandMesh::across_and_lean`]). Of points `u` and `v` are the normal's parts along [`StrandMesh::across_points`].
pub struct StrandMesh {
    kind: StrandShape,
    /// Places and radii at steps of time. The first and the last of a curve stand twice: the ends of Catmull-Rom curves.
    keys: Vec<Vec<[f32; 4]>>,
    /// The first of the four keys of each segment; of points none.
    segments: Vec<u32>,
    /// The curve that each segment is of; of points none.
    curves: Vec<u32>,
}

impl StrandMesh {
    /// Of segments from one vertex to another, or of points (then both are one). A segment that begins where the last one ended
    /// goes on with its curve. `steps`: the vertices at equal steps of time, one if they stand still.
    ///
    /// # Errors
    /// If there are more steps than Embree takes, or a vertex does not exist.
    pub fn new(
        kind: StrandShape,
        steps: &[Vec<[f32; 3]>],
        radii: &[f32],
        segments: impl Iterator<Item = [u32; 2]> + Clone,
    ) -> Result<Self, EmbreeError> {
        if steps.len() > 1 {
            check_steps(steps.len())?;
        }
        let count = radii.len();
        let is_there = |i: u32| (i as usize) < count;
        if steps.iter().any(|step| step.len() != count) || !segments.clone().flatten().all(is_there)
        {
            let words = "strands refer to vertices beyond those that there are";
            return Err(EmbreeError(words.into()));
        }
        let (mut order, mut firsts, mut curves) = (Vec::new(), Vec::new(), Vec::new());
        let (mut end, mut curve) = (None, 0);
        for [from, to] in segments.clone() {
            if kind == StrandShape::Points {
                order.push(from);
                continue;
            }
            if end == Some(from) {
                // The doubled end becomes the next key.
                order.pop();
            } else {
                order.extend([from, from]);
                curve += 1;
            }
            curves.push(curve);
            firsts.push(u32::try_from(order.len() - 2).unwrap_or(u32::MAX));
            order.extend([to, to]);
            end = Some(to);
        }
        let keys = steps.iter().map(|places| {
            let key = |&i: &u32| {
                let [x, y, z] = places[i as usize];
                [x, y, z, radii[i as usize]]
            };
            order.iter().map(key).collect()
        });
        Ok(Self {
            kind,
            keys: keys.collect(),
            segments: firsts,
            curves,
        })
    }

    /// One segment or point as it is at a time.
    pub fn at_time(&self, segment: u32, time: f32) -> Self {
        let keys = self.keys_at(segment, time).map(|key| key.to_array());
        let (keys, segments, curves) = match self.kind {
            StrandShape::Points => (vec![keys[1]], Vec::new(), Vec::new()),
            _ => (keys.to_vec(), vec![0], vec![self.curve_of(segment)]),
        };
        Self {
            kind: self.kind,
            keys: vec![keys],
            segments,
            curves,
        }
    }

    /// The number of the curve that a segment is of, or of the point.
    pub fn curve_of(&self, segment: u32) -> u32 {
        match self.kind {
            StrandShape::Points => segment,
            _ => self.curves[segment as usize],
        }
    }

    /// What they look like.
    pub fn kind(&self) -> StrandShape {
        self.kind
    }

    /// Bytes of the keys and of the numbers of segments and curves.
    pub fn bytes(&self) -> usize {
        self.keys.iter().map(|keys| keys.len() * 16).sum::<usize>() + self.segments.len() * 8
    }

    /// The keys about a segment at a time, the segment from the second to the third; of a point four times the same.
    pub fn keys_at(&self, segment: u32, time: f32) -> [Vec4; 4] {
        let intervals = self.keys.len() - 1;
        if intervals == 0 {
            return self.keys_of(segment, 0);
        }
        let place = time.clamp(0.0, 1.0) * intervals as f32;
        let step = (place as usize).min(intervals - 1);
        let share = place - step as f32;
        let [before, after] = [step, step + 1].map(|step| self.keys_of(segment, step));
        [0, 1, 2, 3].map(|i| before[i] * (1.0 - share) + after[i] * share)
    }

    fn keys_of(&self, segment: u32, step: usize) -> [Vec4; 4] {
        let keys = &self.keys[step];
        if self.kind == StrandShape::Points {
            return [Vec4::from(keys[segment as usize]); 4];
        }
        let first = self.segments[segment as usize] as usize;
        [0, 1, 2, 3].map(|i| Vec4::from(keys[first + i]))
    }

    /// Place and radius on a segment, and how they change along it.
    pub fn on_curve(kind: StrandShape, [a, b, c, d]: [Vec4; 4], u: f32) -> (Vec4, Vec4) {
        if !matches!(kind, StrandShape::Ribbon(_) | StrandShape::Round) {
            return (b + (c - b) * u, c - b);
        }
        // Catmull and Rom's uniform curve, of half the way between the neighbours at each key.
        let (first, third) = ((c - a) * 0.5, (d - b) * 0.5);
        let square = (c - b) * 3.0 - first * 2.0 - third;
        let cube = (b - c) * 2.0 + first + third;
        let at = b + (first + (square + cube * u) * u) * u;
        (at, first + (square * 2.0 + cube * (3.0 * u)) * u)
    }

    /// The normal around a strand that `v` stands for, of unit length.
    pub fn around(tangent: Vec3, direction: Vec3, v: f32) -> Vec3 {
        let [across, facing] = Self::across(tangent, direction);
        let is_far = v.abs() > 1.0;
        let sine = if is_far {
            (2.0 - v.abs()).copysign(v)
        } else {
            v
        };
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        across * sine + facing * if is_far { -cosine } else { cosine }
    }

    /// What lies across as [`Self::around`] takes it, and the sine by which the normal leans along the strand, of a hit's `v`.
    pub fn across_and_lean(v: f32) -> (f32, f32) {
        let steps = (v / LEAN).round();
        (v - steps * LEAN, steps / LEANS)
    }

    /// Across a strand, and towards the viewer, as `v` counts: both unit and at right angles to the tangent.
    pub fn across(tangent: Vec3, direction: Vec3) -> [Vec3; 2] {
        let view = -direction.normalize_or_zero();
        let along = tangent.normalize_or(Self::across_points(direction)[0]);
        let across = along.cross(view);
        // Seen along the strand any side will do.
        let across = across.try_normalize();
        let across = across.unwrap_or_else(|| along.any_orthonormal_vector());
        [across, across.cross(along)]
    }

    /// Across the view of a point, as `u` and `v` count.
    pub fn across_points(direction: Vec3) -> [Vec3; 2] {
        let view = direction.try_normalize().unwrap_or(Vec3::Z);
        let (x, y) = view.any_orthonormal_pair();
        [x, y]
    }
}

impl Scene {
    /// Adds strands or points; their hits are put before the filters of queries. `mask`: see [`super::Ray::mask`].
    ///
    /// # Errors
    /// If Embree refuses them or memory is short.
    pub fn add_strands(
        &mut self,
        strands: &Arc<StrandMesh>,
        mask: u32,
    ) -> Result<u32, EmbreeError> {
        let kind = match strands.kind {
            StrandShape::Ribbon(_) => sys::RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE,
            StrandShape::Round => sys::RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE,
            StrandShape::RoundLinear => sys::RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE,
            StrandShape::Points => sys::RTC_GEOMETRY_TYPE_SPHERE_POINT,
        };
        // The segment of a straight piece begins at the second of its four keys.
        let skipped = usize::from(strands.kind == StrandShape::RoundLinear);
        let id = self.attach(kind, |geometry| {
            // SAFETY: the buffers live in `strands`, which this scene keeps; they are not changed any more. Each segment has four
            // keys from its first on, so that Embree reads none beyond the last; elements are 16 bytes, as Embree reads them.
            unsafe {
                sys::rtcSetGeometryTimeStepCount(geometry, strands.keys.len() as u32);
                for (step, keys) in (0..).zip(&strands.keys) {
                    sys::rtcSetSharedGeometryBuffer(
                        geometry,
                        sys::RTC_BUFFER_TYPE_VERTEX,
                        step,
                        sys::RTC_FORMAT_FLOAT4,
                        keys.as_ptr().add(skipped).cast(),
                        0,
                        size_of::<[f32; 4]>(),
                        keys.len() - skipped,
                    );
                }
                if strands.kind != StrandShape::Points {
                    sys::rtcSetSharedGeometryBuffer(
                        geometry,
                        sys::RTC_BUFFER_TYPE_INDEX,
                        0,
                        sys::RTC_FORMAT_UINT,
                        strands.segments.as_ptr().cast(),
                        0,
                        size_of::<u32>(),
                        strands.segments.len(),
                    );
                }
                if let StrandShape::Ribbon(pieces) = strands.kind {
                    sys::rtcSetGeometryTessellationRate(geometry, f32::from(pieces.max(1)));
                } else {
                    let data: *const StrandMesh = Arc::as_ptr(strands);
                    sys::rtcSetGeometryUserData(geometry, data.cast_mut().cast());
                    sys::rtcSetGeometryIntersectFilterFunction(geometry, Some(round_filter));
                    sys::rtcSetGeometryOccludedFilterFunction(geometry, Some(round_filter));
                }
                sys::rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
                sys::rtcSetGeometryMask(geometry, mask);
            }
            Ok(())
        })?;
        self.handle.strands.push(strands.clone());
        Ok(id)
    }
}

/// Tells a hit of something round where it lies across. Points are met from outside alone, as in Cycles. Called by Embree.
unsafe extern "C" fn round_filter(args: *const sys::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes valid arguments; with single-ray queries N is 1, so that the ray and hit are plain RTCRay and RTCHit;
    // the user data is the StrandMesh that the scene of the geometry keeps. Embree takes the hit from here once it is accepted.
    unsafe {
        let args = &*args;
        if args.N != 1 || *args.valid != -1 {
            return;
        }
        let (r, h) = (
            &*args.ray.cast::<sys::RTCRay>(),
            &mut *args.hit.cast::<sys::RTCHit>(),
        );
        let strands = &*args.geometryUserPtr.cast::<StrandMesh>();
        // Ray and normal are both in the space of the strands, also of instances.
        let direction = Vec3::new(r.dir_x, r.dir_y, r.dir_z);
        let outside = Vec3::new(h.Ng_x, h.Ng_y, h.Ng_z);
        let normal = outside.normalize_or(-direction.normalize_or_zero());
        if strands.kind == StrandShape::Points {
            if outside.dot(direction) > 0.0 {
                *args.valid = 0;
                return;
            }
            let [x, y] = StrandMesh::across_points(direction);
            (h.u, h.v) = (normal.dot(x), normal.dot(y));
            return;
        }
        let keys = strands.keys_at(h.primID, r.time);
        let (_, along) = StrandMesh::on_curve(strands.kind, keys, h.u);
        // Around the strand alone: where that grows thinner the normal leans forward.
        let [across, facing] = StrandMesh::across(along.truncate(), direction);
        let (beside, before) = (normal.dot(across), normal.dot(facing));
        let around = glam::Vec2::new(beside, before).length();
        let sine = if around > 0.0 { beside / around } else { 0.0 };
        let v = if before < 0.0 {
            (2.0 - sine.abs()).copysign(sine)
        } else {
            sine
        };
        // Cones lean, and the spheres at their ends; Cycles has what is bent at right angles to its curve.
        let leans = strands.kind == StrandShape::RoundLinear;
        let lean = if leans {
            normal.dot(along.truncate().normalize_or_zero())
        } else {
            0.0
        };
        h.v = v + (lean * LEANS).round() * LEAN;
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/ffi/embree/strands.rs"]
mod tests;
