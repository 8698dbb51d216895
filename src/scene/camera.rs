//! Cameras as files describe them.

use super::{CameraMotion, RenderDefaults};
use crate::math::panorama::Panorama;
use glam::DAffine3;

/// A camera; it looks down its -Z axis, +Y is up in the picture.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Name of the node or camera in the file.
    pub name: String,
    /// Camera space to world space. Scale is ignored, as in Blender.
    pub world_from_camera: DAffine3,
    /// How points are projected.
    pub projection: Projection,
    /// The edges of the picture, in the place of what `projection` says of them.
    pub window: Option<Window>,
    /// Nearest visible distance along the view axis, metres (of a panorama: from the camera).
    pub clip_near: f64,
    /// Farthest visible distance, measured alike (infinite where the file gives none).
    pub clip_far: f64,
    /// The opening of the lens; `None` is a pinhole.
    pub aperture: Option<Aperture>,
    /// How it moves while the shutter is open.
    pub motion: Option<Box<CameraMotion>>,
    /// Of a panorama: an eye beside the middle for each direction.
    pub stereo: Option<SphericalStereo>,
}

/// Spherical stereo, as Cycles has it: each ray of a panorama starts beside its middle, to the right of where it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalStereo {
    /// How far to the right, metres; a left eye's is negative.
    pub offset: f64,
    /// How far away both eyes see the same; infinite where they look alike.
    pub convergence: f64,
    /// Angles from the horizon between which the offset fades to nothing, radians.
    pub pole_merge: Option<[f64; 2]>,
}

impl SphericalStereo {
    /// Whether its numbers are some.
    pub fn is_sane(&self) -> bool {
        let merges = |[from, to]: [f64; 2]| from.is_finite() && to.is_finite();
        self.offset.is_finite() && self.convergence > 0.0 && self.pole_merge.is_none_or(merges)
    }
}

/// Projections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through one point.
    Perspective {
        /// Vertical field of view, radians.
        vertical_fov: f64,
        /// Width over height that the file intends, if it says so.
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the visible width, metres.
        half_width: f64,
        /// Half the visible height, metres.
        half_height: f64,
    },
    /// All directions about the camera, longitude from left to right and latitude from bottom to top;
    /// 0, 0 is straight ahead.
    Equirectangular {
        /// At the left and at the right edge, radians.
        longitude: [f64; 2],
        /// At the bottom and at the top edge, radians.
        latitude: [f64; 2],
    },
    /// Another panorama.
    Panorama {
        /// Which.
        kind: Panorama,
        /// How far the picture is moved, in its width and height.
        shift: [f64; 2],
    },
}

impl Projection {
    /// Whether depths are distances from the camera.
    pub fn is_panorama(&self) -> bool {
        matches!(self, Self::Equirectangular { .. } | Self::Panorama { .. })
    }
}

/// Edges of the picture: tangents of the angles to −Z (perspective), metres (orthographic).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Left edge.
    pub left: f64,
    /// Right edge.
    pub right: f64,
    /// Bottom edge.
    pub bottom: f64,
    /// Top edge.
    pub top: f64,
}

impl Window {
    /// Width over height.
    pub fn aspect(&self) -> f64 {
        (self.right - self.left) / (self.top - self.bottom)
    }

    /// Made wider about its middle along the side that is too short for an aspect.
    #[must_use]
    pub fn widened_to(&self, aspect: f64) -> Self {
        let (mut x, mut y) = (self.right - self.left, self.top - self.bottom);
        if x < y * aspect {
            x = y * aspect;
        } else {
            y = x / aspect;
        }
        let (cx, cy) = (self.left + self.right, self.bottom + self.top);
        Self {
            left: 0.5 * (cx - x),
            right: 0.5 * (cx + x),
            bottom: 0.5 * (cy - y),
            top: 0.5 * (cy + y),
        }
    }

    /// Whether it has a size.
    pub fn is_sane(&self) -> bool {
        let edges = [self.left, self.right, self.bottom, self.top];
        edges.iter().all(|e| e.is_finite()) && self.left < self.right && self.bottom < self.top
    }
}

/// The opening of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Metres.
    pub radius: f64,
    /// Corners of the polygon; fewer than 3 are a circle.
    pub blades: u32,
    /// Of the polygon, radians, counter-clockwise as seen from behind the camera.
    pub rotation: f64,
    /// Anamorphic: the opening is that much narrower along X.
    pub ratio: f64,
    /// Distance of what is sharp, along −Z (of a panorama: from the camera), metres; may be infinite.
    pub focus_distance: f64,
}

impl Aperture {
    /// Whether there is such a lens.
    pub fn is_sane(&self) -> bool {
        let positive = |n: f64| n.is_finite() && n > 0.0;
        positive(self.radius)
            && positive(self.ratio)
            && self.focus_distance > 0.0
            && self.rotation.is_finite()
    }
}

impl Camera {
    /// Width over height of the picture that it is meant for.
    pub fn aspect(&self) -> Option<f64> {
        let by_projection = match self.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic {
                half_width,
                half_height,
            } => Some(half_width / half_height),
            Projection::Equirectangular {
                longitude: [left, right],
                latitude: [bottom, top],
            } => return Some(((right - left) / (top - bottom)).abs()),
            Projection::Panorama { .. } => return Some(1.0),
        };
        self.window
            .as_ref()
            .map(Window::aspect)
            .or(by_projection)
            .filter(|aspect| aspect.is_finite() && *aspect > 0.0)
    }

    /// A pinhole in a place, with a vertical field of view in radians.
    pub fn perspective(world_from_camera: DAffine3, vertical_fov: f64) -> Self {
        Self {
            name: "camera".into(),
            world_from_camera,
            projection: Projection::Perspective {
                vertical_fov,
                aspect: None,
            },
            window: None,
            clip_near: 0.1,
            clip_far: f64::INFINITY,
            aperture: None,
            motion: None,
            stereo: None,
        }
    }

    /// Width over height of one pixel, where the file says both what the picture's edges are and how many
    /// pixels lie between them: 1 for nearly all.
    pub fn pixel_aspect(&self, render: &RenderDefaults) -> f64 {
        match (&self.window, render.width, render.height) {
            (Some(window), Some(width), Some(height)) if width > 0 && height > 0 => {
                window.aspect() * f64::from(height) / f64::from(width)
            }
            _ => 1.0,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/camera.rs"]
mod tests;
