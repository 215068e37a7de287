//! The JSON Schema of a pipeline file, for completion and checks in editors.

use super::read::accepts;
use super::sections::{SECTIONS, STAGE, is_required};
use crate::params::{Field, Kind, Value};
use crate::stages::{Entry, REGISTRY};
use serde_json::{Map, Value as Json, json};

/// The schema, as the text of `squirm.schema.json`.
#[must_use]
pub fn schema() -> String {
    let mut properties = Map::new();
    let mut required = vec![json!(STAGE)];
    for section in SECTIONS {
        let table = if section.name == STAGE {
            json!({ "oneOf": REGISTRY.iter().map(stage).collect::<Vec<_>>() })
        } else {
            table(&(section.fields)(), None)
        };
        let mut value = if section.repeated { json!({ "type": "array", "items": table }) } else { table };
        value["description"] = json!((section.summary)());
        properties.insert(section.name.into(), value);
        if section.is_required() {
            required.push(json!(section.name));
        }
    }
    let root = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "squirm pipeline",
        "description": "Units: a (cell edge), m (particle mass), kT, tau = a sqrt(m/kT).",
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    let mut text = serde_json::to_string_pretty(&root).expect("a tree of plain values");
    text.push('\n');
    text
}

fn stage(entry: &Entry) -> Json {
    let mut value = table(&(entry.fields)(), Some(entry.kind));
    value["title"] = json!(entry.kind);
    value["description"] = json!((entry.summary)());
    value
}

/// The schema of a table; `kind` adds the key that tells stages apart.
fn table(fields: &[Field], kind: Option<&str>) -> Json {
    let mut properties = Map::new();
    let mut required: Vec<&str> = Vec::new();
    if let Some(kind) = kind {
        properties.insert("kind".into(), json!({ "const": kind, "description": "What the stage does." }));
        required.push("kind");
    }
    for field in fields {
        properties.insert(field.name.into(), property(field));
        if is_required(field) {
            required.push(field.name);
        }
    }
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

fn property(field: &Field) -> Json {
    let mut value = type_of(field.kind);
    value["description"] = json!(format!("{} ({}.)", field.doc, accepts(field)));
    if let Some(default) = &field.default {
        value["default"] = plain(default);
    }
    value
}

fn type_of(kind: Kind) -> Json {
    let number = |min: f64, max: f64| json!({ "type": "number", "minimum": min, "maximum": max });
    let whole = |min: i64, max: i64| json!({ "type": "integer", "minimum": min, "maximum": max });
    let exactly =
        |len: usize, items: Json| json!({ "type": "array", "items": items, "minItems": len, "maxItems": len });
    match kind {
        Kind::Float { min, max } => number(min, max),
        Kind::Integer { min, max } => whole(min, max),
        Kind::Boolean => json!({ "type": "boolean" }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Choice(words) => json!({ "type": "string", "enum": words }),
        Kind::Vector { len, min, max } => exactly(len, number(min, max)),
        Kind::Counts { len, min, max } => exactly(len, whole(min, max)),
        Kind::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Kind::Words(words) => json!({ "type": "array", "items": { "type": "string", "enum": words } }),
        Kind::Rows { len } => json!({ "type": "array", "items": exactly(len, json!({ "type": "number" })) }),
        Kind::Table { fields } => table(&fields(), None),
    }
}

fn plain(value: &Value) -> Json {
    match value {
        Value::Float(x) => json!(x),
        Value::Integer(i) => json!(i),
        Value::Boolean(b) => json!(b),
        Value::Text(t) => json!(t),
        Value::Vector(v) => json!(v),
        Value::Counts(v) => json!(v),
        Value::Words(v) => json!(v),
        Value::Rows(v) => json!(v),
        Value::Table(values) => Json::Object(values.iter().map(|(k, v)| (k.to_string(), plain(v))).collect()),
    }
}
