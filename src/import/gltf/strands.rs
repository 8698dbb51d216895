//! Lines and points with a radius, which are strands of hair and spheres (`strands` of `SUNDOG_mesh`).

use super::accessor::{self, Source};
use super::container::Document;
use super::strokes::Stroke;
use crate::import::budget::Budget;
use crate::scene::{Mesh, StrandShape, Strands};
use serde::Deserialize;

/// What the extension says of a primitive of lines or points.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct StrandsJson {
    shape: ShapeJson,
    /// The attribute with the radius of each vertex.
    pub radius: String,
    /// Pieces of a ribbon for each segment.
    #[serde(default = "one")]
    steps: u8,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ShapeJson {
    Ribbon,
    Round,
    RoundLinear,
    Points,
}

fn one() -> u8 {
    1
}

/// What they look like, and the accessor of their radii.
#[derive(Clone, Copy, Debug)]
pub(super) struct StrandsSource {
    shape: StrandShape,
    radius: usize,
}

impl StrandsSource {
    /// By the extension, and the accessor of the attribute that it names.
    pub fn new(json: &StrandsJson, radius: usize) -> Self {
        let shape = match json.shape {
            ShapeJson::Ribbon => StrandShape::Ribbon(json.steps.max(1)),
            ShapeJson::Round => StrandShape::Round,
            ShapeJson::RoundLinear => StrandShape::RoundLinear,
            ShapeJson::Points => StrandShape::Points,
        };
        Self { shape, radius }
    }

    /// Makes strands of a mesh by what its primitive draws.
    pub fn draw(
        self,
        document: &Document,
        mesh: &mut Mesh,
        stroke: Option<Stroke>,
        budget: &Budget,
    ) -> Result<(), String> {
        let Some(stroke) = stroke else {
            return Err("its strands are drawn as triangles, not as lines or points".into());
        };
        if stroke.is_points() != (self.shape == StrandShape::Points) {
            return Err("its strands have the shape of points but are lines, or are points and have another".into());
        }
        let source = Source {
            index: self.radius,
            unpacked: None,
        };
        let radii = accessor::read_f32::<1>(document, source, budget)?;
        if radii.len() != mesh.positions.len() {
            return Err(format!(
                "it has {} positions but {} radii",
                mesh.positions.len(),
                radii.len()
            ));
        }
        budget.take(stroke.ends().len() as u64, 12)?;
        let corners = stroke.ends().iter().map(|&[from, to]| {
            if self.shape == StrandShape::Points {
                Strands::point(from)
            } else {
                Strands::segment(from, to)
            }
        });
        mesh.triangles = corners.collect();
        mesh.strands = Some(Strands {
            shape: self.shape,
            // What is no size is none.
            radii: radii
                .iter()
                .map(|&[r]| if r > 0.0 && r.is_finite() { r } else { 0.0 })
                .collect(),
            normals: mesh.normals.take().unwrap_or_default(),
        });
        Ok(())
    }
}
