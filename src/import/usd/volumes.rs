//! Volumes: a grid of an OpenVDB file in a box that holds all of it.

use std::collections::HashMap;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::source::{Source, View};
use super::transform;
use crate::import::budget::Budget;
use crate::import::vdb;
use crate::math::BOX_SIDES;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::principled_volume;
use crate::scene::graph::{Function, Graph, Node, NodeKind, VolumeShader};
use crate::scene::{
    Diagnostics, Effect, Grid, Grids, Interpolation, Material, Medium, Mesh, Verdict,
};

/// Points around the set ones in which linear interpolation still finds something.
const MARGIN: f64 = 1.0;

/// Grids that have been read.
pub(super) struct Volumes {
    known: HashMap<(PathBuf, String), Arc<Grid>>,
    budget: Budget,
}

impl Volumes {
    /// Grids may take so many bytes.
    pub(super) fn new(allowed: Option<u64>) -> Self {
        Self {
            known: HashMap::new(),
            budget: Budget::for_grids(allowed),
        }
    }

    /// The box of a volume, filled with its density; its material is still to come.
    pub(super) fn load(
        &mut self,
        (source, prim): (&Source, &View),
        name: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Mesh> {
        let mut lose = |what: String, instead: &str| {
            let path = prim.path().to_string();
            diagnostics.report_effect(
                Effect::Media,
                "usd-volume",
                Verdict::Lost,
                what,
                path,
                instead,
            );
        };
        let mut fields: Vec<&String> = prim.names.iter().collect();
        fields.retain(|name| name.starts_with("field:"));
        fields.sort();
        let density = match fields.iter().find(|name| **name == "field:density") {
            Some(field) => field,
            None => match fields.as_slice() {
                [only] => only,
                _ => {
                    lose(
                        "volumes without a field that is their density".into(),
                        "left out",
                    );
                    return None;
                }
            },
        };
        for other in fields.iter().filter(|name| *name != density) {
            let what = format!(
                "fields of volumes beside the density ({})",
                &other["field:".len()..]
            );
            lose(what, "they change nothing");
        }
        match self.field(source, prim, density) {
            Ok(grid) => Some(boxed(&grid, name)?),
            Err(problem) => {
                lose(
                    format!("volume that cannot be read ({problem})"),
                    "left out",
                );
                None
            }
        }
    }

    /// The grid of a field, in the volume's own space.
    fn field(&mut self, source: &Source, volume: &View, name: &str) -> Result<Arc<Grid>, String> {
        let targets = volume.targets(name);
        let path = targets.first().ok_or("its field leads nowhere")?;
        let field = source.view(path);
        if field.kind() != "OpenVDBAsset" {
            return Err(format!(
                "its field is no OpenVDBAsset but \"{}\"",
                field.kind()
            ));
        }
        // Where the field is: below the volume, as exporters have it.
        let mut place = DAffine3::IDENTITY;
        let mut at = path.clone();
        while at != *volume.path() {
            if at.is_abs_root() {
                return Err("its field does not stand below it".into());
            }
            place = transform::local(&source.view(&at), &mut Diagnostics::default()).matrix * place;
            at = at.parent().ok_or("its field does not stand below it")?;
        }
        if place.matrix3.determinant() == 0.0 {
            return Err("its field has no extent".into());
        }
        let (file, called) = field.asset("filePath").ok_or("its field names no file")?;
        let grid = field.word("fieldName").unwrap_or_else(|| "density".into());
        let file = source.files.place(&file)?;
        let key = (file, format!("{grid} {:?}", place.to_cols_array()));
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let read = vdb::read(FilePath::new(&key.0), &grid, &self.budget);
        let mut read = read.map_err(|problem| format!("{called}: {problem}"))?;
        read.object_from_index = place * read.object_from_index;
        let read = Arc::new(read);
        self.known.insert(key, read.clone());
        Ok(read)
    }
}

/// A box around all that a grid has, in the grid's own axes; none around nothing.
fn boxed(grid: &Arc<Grid>, name: &str) -> Option<Mesh> {
    let (low, high) = grid.active?;
    let (low, high) = (low.as_dvec3() - MARGIN, high.as_dvec3() + MARGIN);
    let corner = |number: u32| {
        let bits = DVec3::from([0, 1, 2].map(|axis| f64::from(number >> axis & 1)));
        let place = grid
            .object_from_index
            .transform_point3(low + (high - low) * bits);
        place.as_vec3().to_array()
    };
    let mirrored = grid.object_from_index.matrix3.determinant() < 0.0;
    let triangles = BOX_SIDES.iter().flat_map(|[a, b, c, d]| {
        let (b, d) = if mirrored { (d, b) } else { (b, d) };
        [[*a, *b, *c], [*a, *c, *d]]
    });
    Some(Mesh {
        name: name.into(),
        positions: (0..8).map(corner).collect(),
        triangles: triangles.collect(),
        grids: Some(Arc::new(Grids {
            by_number: vec![Some(grid.clone())],
            density_by_object: true,
        })),
        ..Mesh::default()
    })
}

/// The material of volumes: Blender's, where an object has none. Its density is that of grid 0.
pub(super) fn filling() -> Material {
    let mut inside = Graph::default();
    let grid = PlaceInput::Grid {
        number: 0,
        interpolation: Interpolation::Linear,
        otherwise: 0.0,
    };
    let density = inside.add(Node::new(NodeKind::Function(Function::Place(grid))));
    let shader = Node::new(NodeKind::Volume(VolumeShader::Principled));
    inside.volume = Some(inside.add(shader.with(principled_volume::DENSITY, density)));
    // Light passes the box itself.
    let mut graph = Graph::default();
    graph.surface = Some(graph.add(Node::new(NodeKind::TransparentBsdf)));
    Material {
        name: "(volume)".into(),
        graph,
        double_sided: true,
        medium: Some(Medium {
            varying: Some(Box::new(inside)),
            ..Medium::default()
        }),
        priority: None,
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/volumes.rs"]
mod tests;
