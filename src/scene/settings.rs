//! What a file wishes of the render and of the display, where the user says nothing.

use crate::math::primaries::WorkingSpace;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How the scene is to be shown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorManagement {
    /// OpenColorIO configuration.
    pub config: Option<PathBuf>,
    /// Display.
    pub display: Option<String>,
    /// View.
    pub view: Option<String>,
    /// Look.
    pub look: Option<String>,
    /// Stops.
    pub exposure: Option<f64>,
    /// Gamma after the view.
    pub gamma: Option<f64>,
    /// The space that the scene's colours, and so the picture's, are numbers of.
    #[serde(default)]
    pub working_space: WorkingSpace,
}

/// How the scene is to be rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderDefaults {
    /// Pixels a row.
    pub width: Option<u32>,
    /// Rows.
    pub height: Option<u32>,
    /// Blender's filter width in pixels.
    pub filter_width: Option<f64>,
    /// The world is not in the picture where the camera would see it.
    pub transparent: Option<bool>,
    /// It is not either behind glass up to this roughness.
    pub transparent_glass: Option<f64>,
    /// Factor on all light.
    pub film_exposure: Option<f64>,
}
