//! The JSON of a glTF file, field by field.
//!
//! No schema is imposed on the whole document: a field is looked at when the mesh needs it, so that a fault anywhere
//! else does no harm. The errors are reasons; whoever asks knows the place.

use serde_json::{Map, Value};

/// A JSON object.
pub(super) type Object = Map<String, Value>;

/// A list at the top level of the document.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    pub(super) list: &'static str,
    pub(super) one: &'static str,
}

pub(super) const ACCESSORS: Section = Section { list: "accessors", one: "accessor" };
pub(super) const BUFFERS: Section = Section { list: "buffers", one: "buffer" };
pub(super) const BUFFER_VIEWS: Section = Section { list: "bufferViews", one: "buffer view" };
pub(super) const MESHES: Section = Section { list: "meshes", one: "mesh" };
pub(super) const NODES: Section = Section { list: "nodes", one: "node" };
pub(super) const SCENES: Section = Section { list: "scenes", one: "scene" };

impl Section {
    /// All entries; none if the section is not there.
    pub(super) fn entries<'a>(&self, root: &'a Object) -> Result<&'a [Value], String> {
        list(root, self.list)
    }

    /// The entry of an index.
    pub(super) fn entry<'a>(&self, root: &'a Object, index: usize) -> Result<&'a Object, String> {
        let entry = self.entries(root)?.get(index).ok_or_else(|| format!("there is no such {}", self.one))?;
        entry.as_object().ok_or_else(|| format!("the {} is not an object", self.one))
    }
}

/// A field that is there and not null.
pub(super) fn field<'a>(object: &'a Object, name: &str) -> Option<&'a Value> {
    object.get(name).filter(|v| !v.is_null())
}

/// A whole number that is not negative. Some writers give integers a fraction of zero.
pub(super) fn whole(value: &Value) -> Option<usize> {
    // Beyond 2⁵³ a number with a fraction part cannot be told from its neighbours.
    let real = || value.as_f64().filter(|x| x.fract() == 0.0 && (0.0..=9e15).contains(x)).map(|x| x as u64);
    usize::try_from(value.as_u64().or_else(real)?).ok()
}

/// A field that holds an index, a count or an offset.
pub(super) fn index(object: &Object, name: &str) -> Result<Option<usize>, String> {
    let number = |v| whole(v).ok_or_else(|| format!("\"{name}\" is not a whole number that fits"));
    field(object, name).map(number).transpose()
}

/// A field that holds an index, a count or an offset and must be there.
pub(super) fn required(object: &Object, name: &str) -> Result<usize, String> {
    index(object, name)?.ok_or_else(|| format!("it has no \"{name}\""))
}

/// A field that holds a list; empty if it is not there.
pub(super) fn list<'a>(object: &'a Object, name: &str) -> Result<&'a [Value], String> {
    match field(object, name) {
        None => Ok(&[]),
        Some(Value::Array(list)) => Ok(list),
        Some(_) => Err(format!("\"{name}\" is not a list")),
    }
}

/// A field that holds a list of indices.
pub(super) fn indices(object: &Object, name: &str) -> Result<Vec<usize>, String> {
    let number = |v| whole(v).ok_or_else(|| format!("\"{name}\" is not a list of whole numbers"));
    list(object, name)?.iter().map(number).collect()
}

/// A field that holds N numbers.
pub(super) fn numbers<const N: usize>(object: &Object, name: &str) -> Result<Option<[f64; N]>, String> {
    let Some(value) = field(object, name) else { return Ok(None) };
    (value.as_array())
        .and_then(|list| list.iter().map(Value::as_f64).collect::<Option<Vec<_>>>())
        .and_then(|list| list.try_into().ok())
        .map(Some)
        .ok_or_else(|| format!("\"{name}\" is not a list of {N} numbers"))
}

/// An extension of an object.
pub(super) fn extension<'a>(object: &'a Object, name: &str) -> Option<&'a Value> {
    field(object, "extensions")?.get(name)
}
