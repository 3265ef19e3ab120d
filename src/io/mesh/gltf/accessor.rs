//! Accessors: typed elements in a buffer, some of them replaced (sparse), or zeros.

use std::collections::HashMap;

use nalgebra::Vector3;
use serde_json::Value;

use super::buffers::Buffers;
use super::document::{ACCESSORS, BUFFER_VIEWS, Object, field, index, required};
use crate::io::report::excerpt;

/// The shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec2 => "VEC2",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
        }
    }

    fn width(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
        }
    }
}

/// The type of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(object: &Object) -> Result<Self, String> {
        Ok(match required(object, "componentType")? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(format!("its component type {other} is not one of glTF")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    pub(super) fn is_index(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// A value of this type, and the one that a normalised integer divides by.
    fn value(self, b: &[u8]) -> (f64, f64) {
        match self {
            Self::I8 => (f64::from(b[0] as i8), 127.0),
            Self::U8 => (f64::from(b[0]), 255.0),
            Self::I16 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => (f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), f64::from(u32::MAX)),
            Self::F32 => (f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 1.0),
        }
    }
}

/// Elements in a buffer view, checked to be inside of it.
struct Packed<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Packed<'a> {
    /// `count` elements of `size` bytes, from the view and the offset that `object` names.
    fn new(buffers: &'a Buffers<'_>, object: &Object, count: usize, size: usize) -> Result<Self, String> {
        let view = BUFFER_VIEWS.entry(buffers.root(), required(object, "bufferView")?)?;
        // Zero is not allowed, but can only mean that there is no space between elements.
        let stride = index(view, "byteStride")?.filter(|s| *s > 0).unwrap_or(size);
        if stride < size {
            return Err(format!("its stride of {stride} bytes is shorter than its elements of {size}"));
        }
        let buffer = required(view, "buffer")?;
        let data = buffers.get(buffer).map_err(|e| format!("buffer {buffer}: {e}"))?;
        let start = index(view, "byteOffset")?.unwrap_or(0);
        let in_view = (start.checked_add(required(view, "byteLength")?))
            .and_then(|end| data.get(start..end))
            .ok_or("its buffer view reaches beyond the buffer")?;
        let length = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)),
        };
        let offset = index(object, "byteOffset")?.unwrap_or(0);
        let bytes = (length.and_then(|n| offset.checked_add(n)))
            .and_then(|end| in_view.get(offset..end))
            .ok_or_else(|| format!("its {count} elements reach beyond the buffer view"))?;
        Ok(Self { bytes, stride })
    }

    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..]
    }
}

/// Elements that replace others.
struct Sparse<'a> {
    /// From the index of an element to the number of its replacement.
    slots: HashMap<usize, usize>,
    values: Packed<'a>,
}

impl<'a> Sparse<'a> {
    fn new(buffers: &'a Buffers<'_>, object: &Object, elements: usize, size: usize) -> Result<Self, String> {
        let count = required(object, "count").map_err(|e| format!("sparse: {e}"))?;
        let part = |name: &str| {
            field(object, name).and_then(Value::as_object).ok_or_else(|| format!("sparse: it has no \"{name}\""))
        };
        let (places, values) = (part("indices")?, part("values")?);
        let component = Component::read(places).map_err(|e| format!("sparse indices: {e}"))?;
        if !component.is_index() {
            return Err("sparse indices: they must be unsigned integers".into());
        }
        let size_of_index = component.size();
        let places = Packed::new(buffers, places, count, size_of_index).map_err(|e| format!("sparse indices: {e}"))?;
        let values = Packed::new(buffers, values, count, size).map_err(|e| format!("sparse values: {e}"))?;
        let mut slots = HashMap::with_capacity(count);
        for slot in 0..count {
            let place = component.value(places.get(slot)).0 as usize;
            if place >= elements {
                return Err(format!("sparse indices: number {slot}: {place} is out of range; there are {elements}"));
            }
            slots.insert(place, slot);
        }
        Ok(Self { slots, values })
    }
}

/// The elements of an accessor, all of them readable.
pub(super) struct Elements<'a> {
    dense: Option<Packed<'a>>,
    sparse: Option<Sparse<'a>>,
    pub(super) count: usize,
    pub(super) component: Component,
    normalised: bool,
}

impl<'a> Elements<'a> {
    /// The elements of the accessor `number`, which must have a shape.
    pub(super) fn new(buffers: &'a Buffers<'_>, number: usize, shape: Shape) -> Result<Self, String> {
        let accessor = ACCESSORS.entry(buffers.root(), number)?;
        let component = Component::read(accessor)?;
        match field(accessor, "type") {
            Some(Value::String(name)) if name == shape.name() => {}
            Some(Value::String(name)) => {
                return Err(format!("it holds {}, not {}", excerpt(name.as_bytes()), shape.name()));
            }
            _ => return Err("its \"type\" is not a string".into()),
        }
        let count = required(accessor, "count")?;
        let size = component.size() * shape.width();
        let dense = match field(accessor, "bufferView") {
            Some(_) => Some(Packed::new(buffers, accessor, count, size)?),
            None => None,
        };
        let sparse = match field(accessor, "sparse") {
            Some(Value::Object(sparse)) => Some(Sparse::new(buffers, sparse, count, size)?),
            Some(_) => return Err("its \"sparse\" is not an object".into()),
            None => None,
        };
        // Indices are never fractions, whatever the file says.
        let normalised = shape != Shape::Scalar && field(accessor, "normalized") == Some(&Value::Bool(true));
        Ok(Self { dense, sparse, count, component, normalised })
    }

    /// Whether nothing in the file says what the elements are, so that all of them are zero.
    pub(super) fn are_absent(&self) -> bool {
        self.dense.is_none() && self.sparse.is_none()
    }

    /// Refuses more elements than the bytes of the file can stand for, where elements without bytes are zeros.
    pub(super) fn warranted(self) -> Result<Self, String> {
        let replaced = self.sparse.as_ref().map_or(0, |s| s.slots.len());
        match self.count {
            n if self.has_view() || n <= replaced.saturating_mul(16).max(1 << 16) => Ok(self),
            n => {
                Err(format!("{n} elements without a buffer view; at most 2^16, or 16 for each sparse one, can be read"))
            }
        }
    }

    /// Whether every element takes bytes of the file.
    pub(super) fn has_view(&self) -> bool {
        self.dense.is_some()
    }

    /// Component `c` of element `i`, scaled to [−1, 1] or [0, 1] if it is a normalised integer.
    pub(super) fn get(&self, i: usize, c: usize) -> f64 {
        let replacement = self.sparse.as_ref().and_then(|s| Some(s.values.get(*s.slots.get(&i)?)));
        let Some(bytes) = replacement.or_else(|| Some(self.dense.as_ref()?.get(i))) else { return 0.0 };
        let (value, full) = self.component.value(&bytes[c * self.component.size()..]);
        match self.component {
            Component::F32 => value,
            // The smallest integer of a signed type is one below the negative of the largest.
            _ if self.normalised => (value / full).max(-1.0),
            _ => value,
        }
    }

    pub(super) fn vector(&self, i: usize) -> Vector3<f64> {
        Vector3::from_fn(|c, _| self.get(i, c))
    }
}
