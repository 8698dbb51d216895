//! Cameras, with SUNDOG_camera.

use glam::DAffine3;

use super::camera_schema::{CameraJson, PanoramaJson, SundogCamera};
use super::extensions::report_properties;
use super::placement::matrix;
use super::schema::NodeJson;
use crate::math::panorama::Panorama;
use crate::scene::{
    Aperture, Camera, CameraMotion, Diagnostics, Effect, Projection, SphericalStereo, Verdict,
    Window,
};

/// The camera of a node; `None` if it is neither perspective nor orthographic.
pub(super) fn load_camera(
    source: &CameraJson,
    node: &NodeJson,
    name: &str,
    world: DAffine3,
    diagnostics: &mut Diagnostics,
) -> Option<Camera> {
    let (projection, near, far) = match (&source.perspective, &source.orthographic) {
        (Some(p), _) => (
            Projection::Perspective {
                vertical_fov: p.yfov,
                aspect: p.aspect_ratio,
            },
            p.znear,
            p.zfar.unwrap_or(f64::INFINITY),
        ),
        (None, Some(o)) => (
            Projection::Orthographic {
                half_width: o.xmag.abs(),
                half_height: o.ymag.abs(),
            },
            o.znear,
            o.zfar,
        ),
        (None, None) => return None,
    };
    let name = node
        .name
        .clone()
        .or_else(|| source.name.clone())
        .unwrap_or_else(|| name.into());
    let mut camera = Camera {
        name,
        world_from_camera: world,
        projection,
        window: None,
        clip_near: near,
        clip_far: far,
        aperture: None,
        motion: None,
        stereo: None,
    };
    if let Some(extension) = &source.extensions.sundog {
        apply(extension, &mut camera, diagnostics);
    }
    Some(camera)
}

/// A panorama that is known.
fn panorama(source: &PanoramaJson) -> Option<Projection> {
    let fov = source.fov.unwrap_or(std::f32::consts::PI);
    let sensor = source.sensor.into();
    let kind = match &*source.kind {
        "equirectangular" => {
            return Some(Projection::Equirectangular {
                longitude: source.longitude,
                latitude: source.latitude,
            });
        }
        "fisheye_equidistant" => Panorama::FisheyeEquidistant { fov },
        "fisheye_equisolid" => Panorama::FisheyeEquisolid {
            lens: source.lens.unwrap_or(10.5),
            fov,
            sensor,
        },
        "fisheye_polynomial" => Panorama::FisheyePolynomial {
            coefficients: source.coefficients,
            fov,
            sensor,
        },
        "mirror_ball" => Panorama::MirrorBall,
        "cube_face" => Panorama::CubeFace,
        "central_cylindrical" => Panorama::CentralCylindrical {
            longitude: source.longitude.map(|angle| angle as f32),
            height: source.height,
        },
        _ => return None,
    };
    Some(Projection::Panorama {
        kind,
        shift: source.shift,
    })
}

fn apply(extension: &SundogCamera, camera: &mut Camera, diagnostics: &mut Diagnostics) {
    let owner = format!("camera \"{}\"", camera.name);
    let mut unknown = |properties: &_| {
        report_properties("SUNDOG_camera", properties, &owner, diagnostics);
    };
    unknown(&extension.unknown);
    if let Some([left, right, bottom, top]) = extension.window {
        camera.window = Some(Window {
            left,
            right,
            bottom,
            top,
        });
    }
    if let Some([near, far]) = extension.clip {
        (camera.clip_near, camera.clip_far) = (near, far);
    }
    if let Some(aperture) = &extension.aperture {
        unknown(&aperture.unknown);
        camera.aperture = Some(Aperture {
            radius: aperture.radius,
            blades: aperture.blades,
            rotation: aperture.rotation,
            ratio: aperture.ratio,
            focus_distance: aperture.focus_distance,
        });
    }
    if let Some(panorama) = &extension.panorama {
        unknown(&panorama.unknown);
        if let Some(projection) = self::panorama(panorama) {
            camera.projection = projection;
            if let Some(stereo) = &panorama.stereo {
                unknown(&stereo.unknown);
                camera.stereo = Some(SphericalStereo {
                    offset: stereo.offset,
                    convergence: stereo.convergence.unwrap_or(f64::INFINITY),
                    pole_merge: stereo.pole_merge,
                });
            }
        } else {
            diagnostics.report_effect(
                Effect::PanoramaCamera,
                "panorama-kind",
                Verdict::Lost,
                format!("panoramas of type \"{}\"", panorama.kind),
                owner.clone(),
                "rendered with the perspective that the file gives as well",
            );
        }
    }
    if let Some(motion) = &extension.motion {
        report_properties("SUNDOG_camera", &motion.unknown, &owner, diagnostics);
        let steps = motion.matrices.iter();
        camera.motion = Some(Box::new(CameraMotion {
            steps: steps
                .map(|m| matrix(m, &camera.name, diagnostics))
                .collect(),
            zoom: motion.zoom,
        }));
    }
}
