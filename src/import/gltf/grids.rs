//! Grids of what fills meshes: of OpenVDB files and of arrays (`grids` of `SUNDOG_mesh`).

use super::accessor::{self, Source};
use super::container::{Document, Located};
use super::schema::GridJson;
use crate::import::budget::Budget;
use crate::import::{ImportError, vdb};
use crate::scene::{Diagnostics, Effect, Grid, Grids, Verdict};
use glam::{DAffine3, DMat3, DVec3, IVec3, Vec4};
use std::sync::Arc;

/// Greater numbers no node tree refers to.
const MOST: usize = 256;

/// Reads the grids of a mesh. Those that cannot be read are empty, as in Cycles, and are told.
pub(super) fn load(
    document: &Document,
    (grids, density_by_object): (&[GridJson], bool),
    object: &str,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Arc<Grids>>, ImportError> {
    if grids.is_empty() {
        return Ok(None);
    }
    let mut found = Grids {
        density_by_object,
        ..Grids::default()
    };
    for json in grids.iter().filter(|json| json.number < MOST) {
        let loaded = load_one(document, json, object, budget)?;
        let grid = loaded.unwrap_or_else(|problem| {
            diagnostics.report_effect(
                Effect::Media,
                "broken-grid",
                Verdict::Lost,
                format!("grid \"{}\": {problem}", json.name),
                object,
                "it is 0 everywhere",
            );
            let empty = Grid::new(&*json.name, 1, Vec4::ZERO, DAffine3::IDENTITY, false);
            Arc::new(empty)
        });
        if found.by_number.len() <= json.number {
            found.by_number.resize(json.number + 1, None);
        }
        found.by_number[json.number] = Some(grid);
    }
    Ok(Some(Arc::new(found)))
}

type Loaded = Result<Arc<Grid>, String>;

fn load_one(
    document: &Document,
    json: &GridJson,
    object: &str,
    budget: &Budget,
) -> Result<Loaded, ImportError> {
    let Some(uri) = &json.uri else {
        return Ok(dense(document, json, budget).map(Arc::new));
    };
    let Located::File(path) = document.locate(uri, object)? else {
        return Ok(Err("its file stands in the scene itself".into()));
    };
    let key = (path, json.name.clone());
    let known = document.grids.lock().ok();
    if let Some(grid) = known.and_then(|known| known.get(&key).cloned()) {
        return Ok(Ok(grid));
    }
    let read = vdb::read(&key.0, &json.name, &document.grid_budget).map(Arc::new);
    if let (Ok(grid), Ok(mut known)) = (&read, document.grids.lock()) {
        known.insert(key.clone(), grid.clone());
    }
    Ok(read.map_err(|problem| format!("{}: {problem}", key.0.display())))
}

fn dense(document: &Document, json: &GridJson, budget: &Budget) -> Result<Grid, String> {
    let index = json.accessor.ok_or("it has neither a file nor an array")?;
    let given = Source {
        index,
        unpacked: None,
    };
    let values = accessor::read_f32::<1>(document, given, budget)?;
    let size = IVec3::from(json.size);
    let points = size.max(IVec3::ZERO).as_i64vec3();
    let points = points
        .to_array()
        .into_iter()
        .try_fold(1i64, i64::checked_mul);
    let channels = match points {
        Some(points) if points > 0 => values.len() as i64 / points,
        _ => 0,
    };
    if !matches!(channels, 1 | 3 | 4) || points.map(|p| p * channels) != Some(values.len() as i64) {
        return Err("its array has another size than it says".into());
    }
    let matrix = json.matrix.ok_or("it does not say where it is")?;
    let column = |at: usize| DVec3::new(matrix[at], matrix[at + 4], matrix[at + 8]);
    let place = DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    };
    if !place.is_finite() || place.matrix3.determinant() == 0.0 {
        return Err("it has no extent".into());
    }
    // Half of its leaves may be half empty.
    let bytes = 2 * 4 * values.len() as u64;
    if document.grid_budget.take(bytes, 1).is_err() {
        let (needed, left) = (bytes >> 20, document.grid_budget.left() >> 20);
        return Err(format!(
            "it takes about {needed} MiB of memory, and grids may take {left} more (--max-memory)"
        ));
    }
    let shape = (channels as usize, size);
    Grid::dense(&*json.name, shape, bytemuck::cast_slice(&values), place).map_err(|bytes| {
        format!(
            "it takes {} MiB of memory, and there is not so much",
            bytes.0 >> 20
        )
    })
}
