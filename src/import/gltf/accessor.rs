//! Reading accessors over checked slices.
//!
//! Not the `gltf` crate's iterators: those panic where offsets, strides or counts lie.

use ::gltf::json;
use json::accessor::{ComponentType, Type};
use json::validation::Checked;

use super::container::Document;
use crate::import::budget::Budget;

/// The value of one component from its bytes.
fn decode(bytes: &[u8], kind: ComponentType, normalized: bool) -> f64 {
    // Specification 3.6.2.2: c / (2ⁿ − 1), and max(c / (2ⁿ⁻¹ − 1), −1) for the signed ones.
    match (kind, bytes) {
        (ComponentType::U8, &[a]) => f64::from(a) / if normalized { 255.0 } else { 1.0 },
        (ComponentType::I8, &[a]) => {
            let c = f64::from(i8::from_le_bytes([a]));
            if normalized { (c / 127.0).max(-1.0) } else { c }
        }
        (ComponentType::U16, &[a, b]) => {
            f64::from(u16::from_le_bytes([a, b])) / if normalized { 65535.0 } else { 1.0 }
        }
        (ComponentType::I16, &[a, b]) => {
            let c = f64::from(i16::from_le_bytes([a, b]));
            if normalized {
                (c / 32767.0).max(-1.0)
            } else {
                c
            }
        }
        (ComponentType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (ComponentType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => 0.0,
    }
}

/// Values decoded from a compressed stream: they stand in the place of an accessor's own.
pub(super) struct Unpacked {
    pub component: ComponentType,
    /// Components of an element; elements follow one another without gaps.
    pub components: usize,
    pub bytes: Vec<u8>,
}

/// An accessor to read, and where its values are if they are not where it says.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub index: usize,
    pub unpacked: Option<&'a Unpacked>,
}

impl From<usize> for Source<'_> {
    fn from(index: usize) -> Self {
        Self {
            index,
            unpacked: None,
        }
    }
}

/// A strided run of elements whose every byte is known to be there.
struct Run<'a> {
    data: &'a [u8],
    stride: usize,
    element: usize,
    count: usize,
}

impl<'a> Run<'a> {
    fn new(
        document: &'a Document,
        view: usize,
        offset: u64,
        element: usize,
        count: usize,
    ) -> Result<Self, String> {
        let (data, stride) = document.view(view)?;
        let stride = stride.filter(|&s| s != 0).unwrap_or(element);
        if stride < element {
            return Err(format!(
                "buffer view {view} has a stride of {stride} bytes for elements of {element}"
            ));
        }
        let start = usize::try_from(offset).ok().filter(|&o| o <= data.len());
        let data = start
            .and_then(|o| data.get(o..))
            .ok_or("it begins beyond the end of its buffer view")?;
        let needed = match count {
            0 => Some(0),
            n => (n - 1)
                .checked_mul(stride)
                .and_then(|b| b.checked_add(element)),
        };
        if needed.is_none_or(|n| n > data.len()) {
            return Err(format!(
                "its {count} elements reach beyond the end of its buffer view"
            ));
        }
        Ok(Self {
            data,
            stride,
            element,
            count,
        })
    }

    /// Over elements without gaps.
    fn packed(data: &'a [u8], element: usize, count: usize) -> Result<Self, String> {
        if count.checked_mul(element).is_none_or(|n| n > data.len()) {
            return Err(format!("its {count} elements are more than were decoded"));
        }
        Ok(Self {
            data,
            stride: element,
            element,
            count,
        })
    }

    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (data, stride, element) = (self.data, self.stride, self.element);
        (0..self.count).map(move |i| {
            data.get(i * stride..i * stride + element)
                .unwrap_or_default()
        })
    }
}

/// Number of components of an accessor's elements.
pub(super) fn components(kind: Type) -> usize {
    match kind {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

/// Byte offsets of the components in an element: the columns of matrices start at multiples of four
/// bytes (specification 3.6.2.4). Also the whole element's size.
fn layout(kind: Type, component: usize) -> (Vec<usize>, usize) {
    let rows = match kind {
        Type::Mat2 => 2,
        Type::Mat3 => 3,
        Type::Mat4 => 4,
        other => {
            let n = components(other);
            return ((0..n).map(|i| i * component).collect(), n * component);
        }
    };
    let column = (rows * component).next_multiple_of(4);
    let offsets = (0..rows * rows)
        .map(|i| (i / rows) * column + (i % rows) * component)
        .collect();
    (offsets, rows * column)
}

/// Facts of an accessor that callers check before reading it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub kind: Type,
    pub component: ComponentType,
    pub normalized: bool,
    pub count: usize,
}

/// Looks at an accessor without reading it.
pub(super) fn shape<'a>(
    document: &Document,
    source: impl Into<Source<'a>>,
) -> Result<Shape, String> {
    let Source { index, unpacked } = source.into();
    let accessor = document
        .core
        .accessors
        .get(index)
        .ok_or_else(|| format!("there is no accessor {index}"))?;
    let (Checked::Valid(kind), Checked::Valid(component)) =
        (accessor.type_, accessor.component_type)
    else {
        return Err(format!("accessor {index} has an unknown type"));
    };
    let count = usize::try_from(accessor.count.0)
        .map_err(|_| format!("accessor {index} has an absurd count"))?;
    Ok(Shape {
        kind,
        component: unpacked.map_or(component.0, |u| u.component),
        normalized: accessor.normalized,
        count,
    })
}

/// Reads an accessor of `N` components as `f64`, normalised integers decoded, sparse ones filled in.
pub(super) fn read<'a, const N: usize>(
    document: &Document,
    source: impl Into<Source<'a>>,
    budget: &Budget,
) -> Result<Vec<[f64; N]>, String> {
    let source = source.into();
    let index = source.index;
    let shape = shape(document, source)?;
    let there = source
        .unpacked
        .map_or(components(shape.kind), |u| u.components);
    if there != N {
        return Err(format!(
            "accessor {index} has {there} components where {N} are needed"
        ));
    }
    let size = shape.component.size();
    let (offsets, element) = layout(shape.kind, size);
    let convert = |bytes: &[u8]| {
        let mut values = [0.0; N];
        for (value, &at) in values.iter_mut().zip(&offsets) {
            *value = decode(
                bytes.get(at..at + size).unwrap_or_default(),
                shape.component,
                shape.normalized,
            );
        }
        values
    };
    gather(document, source, shape.count, element, budget, convert)
        .map_err(|problem| format!("accessor {index}: {problem}"))
}

/// Reads an accessor of `N` components as `f32`.
pub(super) fn read_f32<'a, const N: usize>(
    document: &Document,
    source: impl Into<Source<'a>>,
    budget: &Budget,
) -> Result<Vec<[f32; N]>, String> {
    Ok(read::<N>(document, source, budget)?
        .into_iter()
        .map(|v| v.map(|c| c as f32))
        .collect())
}

/// Reads a scalar accessor of unsigned integers.
pub(super) fn read_indices(
    document: &Document,
    index: usize,
    budget: &Budget,
) -> Result<Vec<u32>, String> {
    let shape = shape(document, index)?;
    if shape.kind != Type::Scalar
        || !matches!(
            shape.component,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        )
        || shape.normalized
    {
        return Err(format!("accessor {index} does not hold indices"));
    }
    // Not by way of f64, as in `read`: there are six indices to a vertex.
    let convert = |bytes: &[u8]| match *bytes {
        [a] => u32::from(a),
        [a, b] => u32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        // As in `decode`: elements have the size of their component.
        _ => 0,
    };
    let size = shape.component.size();
    gather(document, index.into(), shape.count, size, budget, convert)
        .map_err(|problem| format!("accessor {index}: {problem}"))
}

/// Converts an accessor's elements in order, then puts its sparse substitutes in their places.
fn gather<T: Copy>(
    document: &Document,
    source: Source,
    total: usize,
    element: usize,
    budget: &Budget,
    convert: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, String> {
    let Some(accessor) = document.core.accessors.get(source.index) else {
        return Err("it does not exist".into());
    };
    // Everything is checked before memory is asked for.
    let dense = match (source.unpacked, &accessor.buffer_view) {
        (Some(unpacked), _) => Some(Run::packed(&unpacked.bytes, element, total)?),
        (None, Some(view)) => Some(Run::new(
            document,
            view.value(),
            accessor.byte_offset.map_or(0, |o| o.0),
            element,
            total,
        )?),
        (None, None) => None,
    };
    let sparse = match &accessor.sparse {
        Some(sparse) => {
            let count = usize::try_from(sparse.count.0)
                .map_err(|_| "its sparse count is absurd".to_string())?;
            let Checked::Valid(kind) = sparse.indices.component_type else {
                return Err("its sparse indices have an unknown type".into());
            };
            let (indices, values) = (&sparse.indices, &sparse.values);
            let at = Run::new(
                document,
                indices.buffer_view.value(),
                indices.byte_offset.0,
                kind.0.size(),
                count,
            )?;
            let with = Run::new(
                document,
                values.buffer_view.value(),
                values.byte_offset.0,
                element,
                count,
            )?;
            Some((at, with, kind.0))
        }
        None => None,
    };
    budget.take(total as u64, size_of::<T>())?;
    let mut result = match dense {
        Some(run) => run.iter().map(&convert).collect(),
        // "When undefined, the accessor MUST be initialized with zeros."
        None => vec![convert(&vec![0; element]); total],
    };
    if let Some((at, with, kind)) = sparse {
        for (place, bytes) in at.iter().zip(with.iter()) {
            let place = decode(place, kind, false) as usize;
            match result.get_mut(place) {
                Some(slot) => *slot = convert(bytes),
                None => {
                    return Err(format!(
                        "its sparse index {place} is beyond its {total} elements"
                    ));
                }
            }
        }
    }
    Ok(result)
}
