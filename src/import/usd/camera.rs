//! Cameras, and what a stage says of the render.

use glam::DAffine3;

use super::source::View;
use crate::scene::{Aperture, Camera, Diagnostics, Projection, Verdict, Window};

/// A camera at the origin, its lengths still in the stage's units.
pub(super) fn load(prim: &View, name: &str, diagnostics: &mut Diagnostics) -> Camera {
    let number = |name: &str, fallback: f64| {
        prim.number(name)
            .filter(|v| v.is_finite())
            .unwrap_or(fallback)
    };
    // Tenths of the stage's unit, all of them.
    let focal = number("focalLength", 50.0);
    let width = number("horizontalAperture", 20.955);
    let height = number("verticalAperture", 15.2908);
    let offset = [
        number("horizontalApertureOffset", 0.0),
        number("verticalApertureOffset", 0.0),
    ];
    let orthographic = prim.word("projection").as_deref() == Some("orthographic");
    // On a plane at distance 1, or in the stage's units.
    let per_tenth = if orthographic { 0.1 } else { 1.0 / focal };
    let sane = width > 0.0 && height > 0.0 && (orthographic || focal > 0.0);
    if !sane {
        diagnostics.report(
            "usd-camera",
            Verdict::Approximated,
            "camera whose film or lens has no size",
            prim.path().to_string(),
            "a field of view of 45° is used",
        );
    }
    let half = |extent: f64| 0.5 * extent * per_tenth;
    let [x, y] = offset.map(|o| o * per_tenth);
    let window = sane.then(|| Window {
        left: x - half(width),
        right: x + half(width),
        bottom: y - half(height),
        top: y + half(height),
    });
    let projection = if orthographic && sane {
        Projection::Orthographic {
            half_width: half(width),
            half_height: half(height),
        }
    } else {
        Projection::Perspective {
            vertical_fov: if sane {
                2.0 * half(height).atan()
            } else {
                45f64.to_radians()
            },
            aspect: sane.then(|| width / height),
        }
    };
    let [near, far] = prim
        .vector::<2>("clippingRange")
        .unwrap_or([1.0, 1_000_000.0]);
    let stop = number("fStop", 0.0);
    let focus = number("focusDistance", 0.0);
    let aperture = (stop > 0.0 && focus > 0.0 && focal > 0.0 && !orthographic).then(|| Aperture {
        radius: 0.05 * focal / stop,
        blades: 0,
        rotation: 0.0,
        ratio: 1.0,
        focus_distance: focus,
    });
    if prim.has("clippingPlanes")
        && prim
            .value("clippingPlanes")
            .is_some_and(|v| super::value::floats(&v).is_some_and(|(_, values)| !values.is_empty()))
    {
        diagnostics.report(
            "usd-camera",
            Verdict::Lost,
            "clipping planes of cameras",
            prim.path().to_string(),
            "nothing is clipped but what is too near or too far",
        );
    }
    if number("exposure", 0.0) != 0.0 {
        diagnostics.report(
            "usd-camera",
            Verdict::Lost,
            "exposure of cameras",
            prim.path().to_string(),
            "the picture is as bright as without; --exposure changes that",
        );
    }
    Camera {
        name: name.into(),
        world_from_camera: DAffine3::IDENTITY,
        projection,
        window,
        clip_near: near,
        clip_far: far,
        aperture,
        motion: None,
        stereo: None,
    }
}

/// A camera in its place, in metres.
pub(super) fn placed(camera: &Camera, world: DAffine3, unit: f64) -> Camera {
    let mut camera = camera.clone();
    camera.world_from_camera = world;
    camera.clip_near *= unit;
    camera.clip_far *= unit;
    if let Some(aperture) = &mut camera.aperture {
        aperture.radius *= unit;
        aperture.focus_distance *= unit;
    }
    if let Projection::Orthographic {
        half_width,
        half_height,
    } = &mut camera.projection
    {
        *half_width *= unit;
        *half_height *= unit;
        if let Some(window) = &mut camera.window {
            for edge in [
                &mut window.left,
                &mut window.right,
                &mut window.bottom,
                &mut window.top,
            ] {
                *edge *= unit;
            }
        }
    }
    camera
}
