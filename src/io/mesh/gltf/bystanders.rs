//! A look at what a mesh does not need, for warnings: nothing here can refuse a file.

use serde_json::Value;

use super::document::{Object, field, whole};
use crate::io::count::plural;
use crate::io::report::Report;

/// What a field should hold.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Object,
    List,
    Text,
    Flag,
    Number,
    /// A list of numbers; of this many, unless it is 0.
    Numbers(usize),
    /// An index into a list at the top level, or just an index if that is not named.
    Index(&'static str),
}

use Kind::{Flag, Index, List, Number, Numbers, Object as Map, Text};

/// For each list at the top level the fields of its entries. A part of a path that ends in "[]" stands for every
/// element of a list. Parents come before what is in them.
const FIELDS: &[(&str, &[(&str, Kind)])] = &[
    (
        "animations",
        &[
            ("channels", List),
            ("channels[]", Map),
            ("channels[].sampler", Index("")),
            ("channels[].target", Map),
            ("channels[].target.node", Index("nodes")),
            ("channels[].target.path", Text),
            ("samplers", List),
            ("samplers[]", Map),
            ("samplers[].input", Index("accessors")),
            ("samplers[].output", Index("accessors")),
            ("samplers[].interpolation", Text),
        ],
    ),
    (
        "cameras",
        &[
            ("type", Text),
            ("perspective", Map),
            ("perspective.yfov", Number),
            ("perspective.znear", Number),
            ("perspective.zfar", Number),
            ("perspective.aspectRatio", Number),
            ("orthographic", Map),
            ("orthographic.xmag", Number),
            ("orthographic.ymag", Number),
            ("orthographic.znear", Number),
            ("orthographic.zfar", Number),
        ],
    ),
    ("images", &[("uri", Text), ("mimeType", Text), ("bufferView", Index("bufferViews"))]),
    (
        "materials",
        &[
            ("pbrMetallicRoughness", Map),
            ("pbrMetallicRoughness.baseColorFactor", Numbers(4)),
            ("pbrMetallicRoughness.baseColorTexture", Map),
            ("pbrMetallicRoughness.baseColorTexture.index", Index("textures")),
            ("pbrMetallicRoughness.metallicFactor", Number),
            ("pbrMetallicRoughness.roughnessFactor", Number),
            ("pbrMetallicRoughness.metallicRoughnessTexture", Map),
            ("pbrMetallicRoughness.metallicRoughnessTexture.index", Index("textures")),
            ("normalTexture", Map),
            ("normalTexture.index", Index("textures")),
            ("normalTexture.scale", Number),
            ("occlusionTexture", Map),
            ("occlusionTexture.index", Index("textures")),
            ("occlusionTexture.strength", Number),
            ("emissiveTexture", Map),
            ("emissiveTexture.index", Index("textures")),
            ("emissiveFactor", Numbers(3)),
            ("alphaMode", Text),
            ("alphaCutoff", Number),
            ("doubleSided", Flag),
        ],
    ),
    (
        "meshes",
        &[("weights", Numbers(0)), ("primitives[].material", Index("materials")), ("primitives[].targets", List)],
    ),
    ("nodes", &[("camera", Index("")), ("skin", Index("skins")), ("weights", Numbers(0))]),
    ("samplers", &[("magFilter", Index("")), ("minFilter", Index("")), ("wrapS", Index("")), ("wrapT", Index(""))]),
    (
        "skins",
        &[
            ("joints", List),
            ("joints[]", Index("nodes")),
            ("skeleton", Index("nodes")),
            ("inverseBindMatrices", Index("accessors")),
        ],
    ),
    ("textures", &[("source", Index("images")), ("sampler", Index("samplers"))]),
];

/// Fields that every entry of those lists may have.
const EVERYWHERE: &[(&str, Kind)] = &[("name", Text), ("extensions", Map)];

/// Warns of fields that do not hold what the standard says, with the first place in each list.
pub(super) fn inspect(root: &Object, report: &mut Report) {
    for (section, fields) in FIELDS {
        let mut faults = Faults { root, n: 0, first: None };
        match field(root, section) {
            Some(Value::Array(entries)) => {
                for (i, entry) in entries.iter().enumerate() {
                    let place = format!("{section}[{i}]");
                    faults.check(entry, Map, &place);
                    for (path, kind) in EVERYWHERE.iter().chain(*fields) {
                        faults.visit(entry, path, *kind, &place);
                    }
                }
            }
            Some(other) => faults.check(other, List, section),
            None => {}
        }
        if let Some((place, reason)) = faults.first {
            let others = match faults.n - 1 {
                0 => String::new(),
                n => format!(", like {} more there", plural(n, "field", "fields")),
            };
            report.warn(place, format!("{reason}{others}; the mesh does not need it"));
        }
    }
}

struct Faults<'a> {
    root: &'a Object,
    n: usize,
    first: Option<(String, String)>,
}

impl Faults<'_> {
    /// Follows a path to its end, wherever that is there, and checks what it finds.
    fn visit(&mut self, value: &Value, path: &str, kind: Kind, place: &str) {
        let (part, rest) = path.split_once('.').map_or((path, None), |(part, rest)| (part, Some(rest)));
        let (name, each) = part.strip_suffix("[]").map_or((part, false), |name| (name, true));
        let Some(value) = value.get(name).filter(|v| !v.is_null()) else { return };
        let place = format!("{place}.{name}");
        let mut found = |value: &Value, place: &str| match rest {
            Some(rest) => self.visit(value, rest, kind, place),
            None => self.check(value, kind, place),
        };
        match value {
            Value::Array(list) if each => {
                list.iter().enumerate().for_each(|(i, value)| found(value, &format!("{place}[{i}]")));
            }
            _ if each => {}
            value => found(value, &place),
        }
    }

    fn check(&mut self, value: &Value, kind: Kind, place: &str) {
        let is_numbers = |n: usize| {
            let list = value.as_array().filter(|l| n == 0 || l.len() == n);
            list.is_some_and(|l| l.iter().all(Value::is_number))
        };
        let fault = match kind {
            Map if !value.is_object() => "is not an object".to_owned(),
            List if !value.is_array() => "is not a list".into(),
            Text if !value.is_string() => "is not a string".into(),
            Flag if !value.is_boolean() => "is neither true nor false".into(),
            Number if !value.is_number() => "is not a number".into(),
            Numbers(0) if !is_numbers(0) => "is not a list of numbers".into(),
            Numbers(n) if !is_numbers(n) => format!("is not a list of {n} numbers"),
            Index(list) => {
                let Some(index) = whole(value) else { return self.add(place, "is not a whole number".into()) };
                let count = self.root.get(list).and_then(Value::as_array).map_or(0, Vec::len);
                if list.is_empty() || index < count {
                    return;
                }
                format!("is {index}, but there are {count} {list}")
            }
            _ => return,
        };
        self.add(place, fault);
    }

    fn add(&mut self, place: &str, reason: String) {
        self.n += 1;
        self.first.get_or_insert_with(|| (place.to_owned(), reason));
    }
}
