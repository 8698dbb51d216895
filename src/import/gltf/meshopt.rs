//! EXT_meshopt_compression and KHR_meshopt_compression, through the crate `meshoptimizer-rs`.

use meshoptimizer_rs::codec;
use meshoptimizer_rs::{Limits, Workspace};
use serde::Deserialize;
use serde_json::Value;

use crate::import::budget::Budget;
use crate::import::guard::guarded;

/// The extension's names; the later one adds a filter and a version of the attribute codec.
const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension's object on a buffer view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Packed {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

/// The extension's object on anything that may have one.
fn extension(owner: &Value) -> Option<&Value> {
    let extensions = owner.get("extensions")?;
    NAMES.iter().find_map(|name| extensions.get(name))
}

/// What a buffer view says of its compressed data; `None` if they are not compressed.
pub(super) fn of_view(view: &Value) -> Option<Result<Packed, String>> {
    let value = extension(view)?;
    Some(
        Packed::deserialize(value)
            .map_err(|e| format!("its meshopt compression cannot be read ({e})")),
    )
}

/// Whether a buffer is only there for programs without the extension.
pub(super) fn is_fallback(buffer: &Value) -> bool {
    extension(buffer)
        .and_then(|e| e.get("fallback"))
        .and_then(Value::as_bool)
        .unwrap_or(false)
}

/// Decodes a buffer view; its size is asked of the budget first.
pub(super) fn decode(packed: &Packed, source: &[u8], budget: &Budget) -> Result<Vec<u8>, String> {
    let (count, stride) = (packed.count, packed.byte_stride);
    if count == 0 {
        return Ok(Vec::new());
    }
    budget.take(count as u64, stride)?;
    let size = count.saturating_mul(stride);
    // Scratch of the codec is a block of at most 8 KiB and some tables.
    let limits = Limits {
        max_bytes: size.saturating_add(1 << 20),
        ..Limits::default()
    };
    let filter = packed.filter.as_deref().unwrap_or("NONE");
    if packed.mode != "ATTRIBUTES" && filter != "NONE" {
        return Err(format!(
            "its meshopt filter {filter} is not for the mode {}",
            packed.mode
        ));
    }
    guarded(|| {
        let mut workspace = Workspace::new(limits);
        let work = &mut workspace;
        let damaged = |e| format!("its meshopt data are damaged ({e})");
        match packed.mode.as_str() {
            "ATTRIBUTES" => {
                let mut data =
                    codec::decode_vertex_buffer(count, stride, source, work).map_err(damaged)?;
                let values = data.as_mut_slice();
                match filter {
                    "NONE" => Ok(()),
                    "OCTAHEDRAL" => codec::decode_filter_oct(values, count, stride, work),
                    "QUATERNION" => codec::decode_filter_quat(values, count, stride, work),
                    "EXPONENTIAL" => codec::decode_filter_exp(values, count, stride, work),
                    "COLOR" => codec::decode_filter_color(values, count, stride, work),
                    other => {
                        return Err(format!(
                            "its meshopt filter is \"{other}\", which Sundog does not know"
                        ));
                    }
                }
                .map_err(damaged)?;
                Ok(data)
            }
            "TRIANGLES" => codec::decode_index_buffer(count, stride, source, work).map_err(damaged),
            "INDICES" => codec::decode_index_sequence(count, stride, source, work).map_err(damaged),
            other => Err(format!(
                "its meshopt mode is \"{other}\", which Sundog does not know"
            )),
        }
    })
}
