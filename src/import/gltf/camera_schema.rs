//! Cameras as a glTF file and its extension tell of them, read in f64.

use serde::Deserialize;
use serde_json::{Map, Value};

#[derive(Debug, Deserialize)]
pub(super) struct CameraJson {
    pub name: Option<String>,
    pub perspective: Option<PerspectiveJson>,
    pub orthographic: Option<OrthographicJson>,
    #[serde(default)]
    pub extensions: CameraExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct CameraExtensions {
    #[serde(rename = "SUNDOG_camera")]
    pub sundog: Option<SundogCamera>,
}

/// What glTF has no word for in a camera. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SundogCamera {
    pub window: Option<[f64; 4]>,
    pub clip: Option<[f64; 2]>,
    pub aperture: Option<ApertureJson>,
    pub panorama: Option<PanoramaJson>,
    pub motion: Option<CameraMotionJson>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// How the camera moves.
#[derive(Debug, Deserialize)]
pub(super) struct CameraMotionJson {
    #[serde(default)]
    pub matrices: Vec<[f64; 16]>,
    #[serde(default = "no_zoom")]
    pub zoom: [f64; 2],
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

fn no_zoom() -> [f64; 2] {
    [1.0; 2]
}

#[derive(Debug, Deserialize)]
pub(super) struct ApertureJson {
    pub radius: f64,
    #[serde(default)]
    pub blades: u32,
    #[serde(default)]
    pub rotation: f64,
    #[serde(default = "super::schema::one")]
    pub ratio: f64,
    pub focus_distance: f64,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
pub(super) struct PanoramaJson {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default = "whole_turn")]
    pub longitude: [f64; 2],
    #[serde(default = "half_turn")]
    pub latitude: [f64; 2],
    pub fov: Option<f32>,
    pub lens: Option<f32>,
    #[serde(default)]
    pub sensor: [f32; 2],
    #[serde(default)]
    pub coefficients: [f32; 5],
    #[serde(default = "unit_span")]
    pub height: [f32; 2],
    #[serde(default)]
    pub shift: [f64; 2],
    pub stereo: Option<StereoJson>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// Spherical stereo.
#[derive(Debug, Deserialize)]
pub(super) struct StereoJson {
    pub offset: f64,
    pub convergence: Option<f64>,
    pub pole_merge: Option<[f64; 2]>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

fn unit_span() -> [f32; 2] {
    [-1.0, 1.0]
}

fn whole_turn() -> [f64; 2] {
    [-std::f64::consts::PI, std::f64::consts::PI]
}

fn half_turn() -> [f64; 2] {
    [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2]
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PerspectiveJson {
    pub aspect_ratio: Option<f64>,
    pub yfov: f64,
    pub zfar: Option<f64>,
    pub znear: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct OrthographicJson {
    pub xmag: f64,
    pub ymag: f64,
    pub zfar: f64,
    pub znear: f64,
}
