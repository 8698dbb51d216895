//! The shutter: when a path is on its way; and the camera, as it is then.

use super::{Aperture, Camera, CameraRay, Eye, Lens, RayMaker};
use crate::math::motion::{self, Decomposed};
use crate::sampler::{Dimension, Sampler};
use glam::{DVec3, Vec2};

/// Steps in which times are drawn, as in Cycles.
const STEPS: usize = 256;

/// Where in the time that it takes the shutter lets light through.
#[derive(Clone, Debug)]
pub struct Shutter {
    /// Times by the share of all light that has come before, at equal steps from 0 to 1; `None`: always as much light.
    times: Option<Box<[f32; STEPS]>>,
    /// Of the whole time, the share in which one row is taken, where rows are taken one after another.
    rolling: Option<f32>,
    camera: Option<Box<MovingCamera>>,
    /// All paths are on their way in the middle.
    still: bool,
}

/// A camera on its way.
#[derive(Clone, Debug)]
pub struct MovingCamera {
    /// What does not move.
    pub lens: Lens,
    /// Of the lens.
    pub aperture: Option<Aperture>,
    /// Where it is at equal steps of time: one step or more.
    pub steps: Vec<Decomposed>,
    /// What the edges of the picture are multiplied with at first and at last.
    pub zoom: [f64; 2],
    /// What positions are relative to.
    pub origin: DVec3,
    /// The clip planes.
    pub clip: (f64, f64),
    /// Middle and radius of all there is, if it is far away.
    pub distant: Option<(DVec3, f64)>,
    /// Of spherical stereo.
    pub eye: Option<Eye>,
}

impl MovingCamera {
    /// As it is at a time between 0 and 1.
    pub fn at(&self, time: f32) -> Camera {
        let place = motion::at(&self.steps, time);
        let zoom = if time < 0.5 {
            self.zoom[0] + (1.0 - self.zoom[0]) * f64::from(time * 2.0)
        } else {
            1.0 + (self.zoom[1] - 1.0) * f64::from(time * 2.0 - 1.0)
        };
        // As in Cycles, only in perspective.
        let lens = match self.lens {
            Lens::Perspective(span) => Lens::Perspective(span.times(zoom as f32)),
            other => other,
        };
        let (near, far) = self.clip;
        let camera =
            Camera::new(lens, self.aperture, &place, self.origin, near, far).with_eye(self.eye);
        match self.distant {
            Some(all) => camera.distant(&place, self.origin, self.clip, all),
            None => camera,
        }
    }
}

impl Shutter {
    /// By how much light it lets through at equal steps of time (none: always as much).
    pub fn new(curve: &[f32], rolling: Option<f32>, camera: Option<MovingCamera>) -> Self {
        Self {
            times: times(curve),
            rolling,
            camera: camera.map(Box::new),
            still: false,
        }
    }

    /// Open in the middle alone, for a camera that stands still.
    pub fn still() -> Self {
        Self {
            still: true,
            ..Self::new(&[], None, None)
        }
    }

    /// The time at which a share of all light has come through, in a row of the picture (counted from the top) of so many.
    ///
    /// A row of a rolling shutter is open for its share of the time, the first one from the beginning and the last one to the
    /// end: as in Cycles, a mean of the time that an unmoved shutter would have it, and of the row's place.
    pub fn time(&self, share: f32, (row, rows): (u32, u32)) -> f32 {
        if self.still {
            return 0.5;
        }
        let time = match &self.times {
            None => share,
            Some(times) => {
                let place = share * (STEPS - 1) as f32;
                let step = (place as usize).min(STEPS - 2);
                let [from, to] = [times[step], times[step + 1]];
                from + (to - from) * (place - step as f32)
            }
        };
        let time = match self.rolling {
            None => time,
            Some(duration) => {
                let here = (row + 1) as f32 / rows as f32;
                let moved = (time - 0.5) * duration + (here - 0.5) * (1.0 - duration) + 0.5;
                if duration > 0.0 { moved } else { here }
            }
        };
        time.clamp(0.0, 1.0)
    }

    /// The ray of a path, at a time of its own. `still`: the camera, where it does not move.
    #[inline(never)]
    pub fn ray(
        &self,
        (still, make): (&Camera, RayMaker),
        (film, rows): (Vec2, (u32, u32)),
        sampler: &Sampler,
    ) -> CameraRay {
        let time = self.time(sampler.single(Dimension::Time, 0), rows);
        let ray = match &self.camera {
            Some(camera) => make(&camera.at(time), film, sampler),
            None => make(still, film, sampler),
        };
        CameraRay { time, ..ray }
    }
}

/// The inverse of how much light has come before a time.
fn times(curve: &[f32]) -> Option<Box<[f32; STEPS]>> {
    let open = |time: f32| {
        let (step, share) = motion::step(time, curve.len());
        curve[step] + (curve[step + 1] - curve[step]) * share
    };
    if curve.len() < 2 || curve.iter().all(|c| *c == curve[0]) {
        return None;
    }
    // The light of each of so many spans of time, by its middle.
    const SPANS: usize = 4 * STEPS;
    let mut before = Vec::with_capacity(SPANS + 1);
    let mut sum = 0.0f64;
    before.push(0.0);
    for span in 0..SPANS {
        sum += f64::from(open((span as f32 + 0.5) / SPANS as f32));
        before.push(sum);
    }
    if sum <= 0.0 {
        return None;
    }
    let mut times = Box::new([0.0f32; STEPS]);
    for (step, time) in times.iter_mut().enumerate() {
        let wanted = sum * step as f64 / (STEPS - 1) as f64;
        // The last span that begins before.
        let span = before.partition_point(|light| *light <= wanted);
        let span = span.clamp(1, SPANS) - 1;
        let (from, to) = (before[span], before[span + 1]);
        let within = if to > from {
            (wanted - from) / (to - from)
        } else {
            1.0
        };
        *time = ((span as f64 + within.clamp(0.0, 1.0)) / SPANS as f64) as f32;
    }
    Some(times)
}

#[cfg(test)]
#[path = "../../tests/unit/camera/shutter.rs"]
mod tests;
