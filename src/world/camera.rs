//! From a scene's camera to one that makes rays.

use crate::camera::{Aperture, Camera, Eye, Lens, MovingCamera, Shutter, Span, nearest_focus};
use crate::effects::Effect;
use crate::math::motion;
use crate::math::panorama::Panorama;
use crate::scene::{self, Projection};
use enumset::EnumSet;
use glam::DVec3;

/// Prepares a camera for a picture of an aspect; positions are relative to `origin`. `distant`: middle and radius of
/// all there is, if it is far away.
pub fn prepare(
    source: &scene::Camera,
    aspect: f64,
    kept: EnumSet<Effect>,
    (origin, distant): (DVec3, Option<(DVec3, f64)>),
) -> Camera {
    let (lens, aperture) = optics(source, aspect, kept);
    let (place, near, far) = (&source.world_from_camera, source.clip_near, source.clip_far);
    let camera = Camera::new(lens, aperture, place, origin, near, far).with_eye(eye(source));
    match distant {
        Some(all) => camera.distant(place, origin, (near, far), all),
        None => camera,
    }
}

/// The shutter and the moving camera, where something moves.
pub fn shutter(
    source: &scene::Camera,
    shutter: &scene::Shutter,
    aspect: f64,
    kept: EnumSet<Effect>,
    (origin, distant): (DVec3, Option<(DVec3, f64)>),
) -> Option<Shutter> {
    if !kept.contains(Effect::MotionBlur) {
        return None;
    }
    if shutter.still {
        return Some(Shutter::still());
    }
    let camera = source.motion.as_ref().map(|moving| {
        let (lens, aperture) = optics(source, aspect, kept);
        let still = std::slice::from_ref(&source.world_from_camera);
        let steps = if moving.steps.is_empty() {
            still
        } else {
            &moving.steps
        };
        MovingCamera {
            lens,
            aperture,
            steps: motion::decompose(steps),
            zoom: moving.zoom,
            origin,
            clip: (source.clip_near, source.clip_far),
            distant,
            eye: eye(source),
        }
    });
    Some(Shutter::new(&shutter.curve, shutter.rolling, camera))
}

/// The eye of spherical stereo.
fn eye(source: &scene::Camera) -> Option<Eye> {
    let stereo = source.stereo.filter(|stereo| stereo.is_sane())?;
    // As Cycles, whose mirror balls are mirrored: right is left there.
    let mirrored = matches!(
        source.projection,
        Projection::Panorama {
            kind: Panorama::MirrorBall,
            ..
        }
    );
    let offset = stereo.offset as f32;
    Some(Eye {
        offset: if mirrored { -offset } else { offset },
        convergence: stereo.convergence as f32,
        pole_merge: stereo.pole_merge.map(|angles| angles.map(|a| a as f32)),
    })
}

/// The lens and its opening.
fn optics(source: &scene::Camera, aspect: f64, kept: EnumSet<Effect>) -> (Lens, Option<Aperture>) {
    let window = source
        .window
        .map(|window| window.widened_to(aspect))
        .map(|w| Span::between([w.left, w.right], [w.bottom, w.top]));
    let lens = match source.projection {
        Projection::Perspective { vertical_fov, .. } => {
            let t = (0.5 * vertical_fov).tan();
            Lens::Perspective(window.unwrap_or(Span::between([-t * aspect, t * aspect], [-t, t])))
        }
        Projection::Orthographic {
            half_width: x,
            half_height: y,
        } => Lens::Orthographic(window.unwrap_or(Span::between([-x, x], [-y, y]))),
        Projection::Equirectangular {
            longitude,
            latitude,
        } => Lens::Equirectangular(Span::between(longitude, latitude)),
        Projection::Panorama {
            kind,
            shift: [x, y],
        } => Lens::Panorama(kind, Span::between([x, 1.0 + x], [y, 1.0 + y])),
    };
    let aperture = source
        .aperture
        .filter(|_| kept.contains(Effect::DepthOfField))
        .map(|a| Aperture {
            radius: a.radius as f32,
            blades: a.blades,
            rotation: a.rotation as f32,
            ratio: a.ratio as f32,
            focus_distance: a.focus_distance.max(nearest_focus(a.radius, a.ratio)) as f32,
        });
    (lens, aperture)
}
