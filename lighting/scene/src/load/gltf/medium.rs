//! The medium in the `extras` of a document.

use glam::{DVec3, Vec3};
use gltf_json::{Extras, Value};

use super::extras::{kind, number};
use crate::load::LoadError;
use crate::load::error::printable;
use crate::{Bounds, Medium, PhaseFunction};

/// The medium that `extras` describe, if they do, in a scene that is moved by
/// `offset`.
pub(super) fn medium(extras: &Extras, offset: DVec3) -> Result<Option<Medium>, LoadError> {
    let Some(extras) = extras else {
        return Ok(None);
    };
    let extras: Value = gltf_json::deserialize::from_str(extras.get())
        .map_err(|error| LoadError::Json(error.to_string()))?;
    let Some(value) = extras.get("medium") else {
        return Ok(None);
    };
    let Some(fields) = value.as_object() else {
        return Err(bad("", value, "an object"));
    };
    for name in fields.keys() {
        if !["sigma_s", "sigma_a", "phase", "g", "k", "box"].contains(&name.as_str()) {
            return Err(LoadError::bad_value(
                "a field of \"medium\" in the extras",
                printable(name),
                "sigma_s, sigma_a, phase, g, k or box",
            ));
        }
    }
    if !fields.contains_key("sigma_s") && !fields.contains_key("sigma_a") {
        return Err(bad("", value, "sigma_s or sigma_a in it"));
    }
    let coefficient = |name: &str| match fields.get(name) {
        None => Ok(Vec3::ZERO),
        Some(value) => number(value)
            .map(Vec3::splat)
            .or_else(|| vector(value))
            .filter(|sigma| sigma.min_element() >= 0.0)
            .ok_or_else(|| bad(name, value, "one number or three, finite, not negative")),
    };
    let medium = Medium::new(coefficient("sigma_s")?, coefficient("sigma_a")?, {
        phase(fields.get("phase"), fields.get("g"), fields.get("k"))?
    })?;
    let Some(value) = fields.get("box") else {
        return Ok(Some(medium));
    };
    let corners = match value.as_array().map(Vec::as_slice) {
        Some([min, max]) => vector(min).zip(vector(max)),
        _ => None,
    };
    let moved = |corner: Vec3| (corner.as_dvec3() - offset).as_vec3();
    let bounds = corners.and_then(|(min, max)| Bounds::new(moved(min), moved(max)).ok());
    match bounds {
        Some(bounds) => Ok(Some(medium.within(bounds))),
        None => Err(bad(
            "box",
            value,
            "two corners [x, y, z], the first below the second on each axis",
        )),
    }
}

fn phase(
    name: Option<&Value>,
    g: Option<&Value>,
    k: Option<&Value>,
) -> Result<PhaseFunction, LoadError> {
    let unasked = |field, value: Option<&Value>| match value {
        Some(value) => Err(bad(field, value, "nothing with this phase function")),
        None => Ok(()),
    };
    let parameter = |field, value: Option<&Value>| {
        let value = value.unwrap_or(&Value::Null);
        match number(value) {
            Some(parameter) if parameter.abs() < 1.0 => Ok(parameter),
            _ => Err(bad(
                field,
                value,
                "a number between -1 and 1, both excluded",
            )),
        }
    };
    match name.map_or(Some("isotropic"), Value::as_str) {
        Some("isotropic") => {
            unasked("g", g)?;
            unasked("k", k)?;
            Ok(PhaseFunction::Isotropic)
        }
        Some("rayleigh") => {
            unasked("g", g)?;
            unasked("k", k)?;
            Ok(PhaseFunction::Rayleigh)
        }
        Some("henyey-greenstein") => {
            unasked("k", k)?;
            Ok(PhaseFunction::HenyeyGreenstein {
                g: parameter("g", g)?,
            })
        }
        Some("cornette-shanks") => {
            unasked("k", k)?;
            Ok(PhaseFunction::CornetteShanks {
                g: parameter("g", g)?,
            })
        }
        Some("schlick") => {
            unasked("g", g)?;
            Ok(PhaseFunction::Schlick {
                k: parameter("k", k)?,
            })
        }
        _ => Err(bad(
            "phase",
            name.unwrap_or(&Value::Null),
            "\"isotropic\", \"rayleigh\", \"henyey-greenstein\", \"cornette-shanks\" or \"schlick\"",
        )),
    }
}

fn bad(field: &str, value: &Value, expected: &'static str) -> LoadError {
    let dot = if field.is_empty() { "" } else { "." };
    LoadError::bad_value(
        format!("\"medium{dot}{field}\" in the extras"),
        match value {
            Value::Number(number) => number.to_string(),
            other => kind(other).into(),
        },
        expected,
    )
}

fn vector(value: &Value) -> Option<Vec3> {
    match value.as_array()?.as_slice() {
        [x, y, z] => Some(Vec3::new(number(x)?, number(y)?, number(z)?)),
        _ => None,
    }
}
