//! The medium in the `extras` of a document.

use glam::Vec3;
use gltf_json::{Extras, Value};

use crate::load::LoadError;
use crate::scene::{Bounds, Medium, PhaseFunction};

/// The medium that `extras` describe, if they do.
pub(super) fn medium(extras: &Extras) -> Result<Option<Medium>, LoadError> {
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
        if !["sigma_s", "sigma_a", "phase", "g", "box"].contains(&name.as_str()) {
            return Err(LoadError::bad_value(
                "a field of \"medium\" in the extras",
                name,
                "sigma_s, sigma_a, phase, g or box",
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
        phase(fields.get("phase"), fields.get("g"))?
    })?;
    let Some(value) = fields.get("box") else {
        return Ok(Some(medium));
    };
    let corners = match value.as_array().map(Vec::as_slice) {
        Some([min, max]) => vector(min).zip(vector(max)),
        _ => None,
    };
    let bounds = corners.and_then(|(min, max)| Bounds::new(min, max).ok());
    match bounds {
        Some(bounds) => Ok(Some(medium.within(bounds))),
        None => Err(bad(
            "box",
            value,
            "two corners [x, y, z], the first below the second on each axis",
        )),
    }
}

fn phase(name: Option<&Value>, g: Option<&Value>) -> Result<PhaseFunction, LoadError> {
    let phase = match (name.map(Value::as_str), name) {
        (None, _) | (Some(Some("isotropic")), _) => PhaseFunction::Isotropic,
        (Some(Some("rayleigh")), _) => PhaseFunction::Rayleigh,
        (Some(Some("henyey-greenstein")), _) => {
            let value = g.unwrap_or(&Value::Null);
            return match number(value) {
                Some(g) if g.abs() < 1.0 => Ok(PhaseFunction::HenyeyGreenstein { g }),
                _ => Err(bad("g", value, "a number between -1 and 1, both excluded")),
            };
        }
        (Some(_), value) => {
            return Err(bad(
                "phase",
                value.unwrap_or(&Value::Null),
                "\"isotropic\", \"rayleigh\" or \"henyey-greenstein\"",
            ));
        }
    };
    match g {
        None => Ok(phase),
        Some(g) => Err(bad("g", g, "nothing unless phase is \"henyey-greenstein\"")),
    }
}

fn bad(field: &str, value: &Value, expected: &'static str) -> LoadError {
    let dot = if field.is_empty() { "" } else { "." };
    LoadError::bad_value(
        format!("\"medium{dot}{field}\" in the extras"),
        value,
        expected,
    )
}

/// A number that is finite as f32.
fn number(value: &Value) -> Option<f32> {
    value
        .as_f64()
        .map(|number| number as f32)
        .filter(|number| number.is_finite())
}

fn vector(value: &Value) -> Option<Vec3> {
    match value.as_array()?.as_slice() {
        [x, y, z] => Some(Vec3::new(number(x)?, number(y)?, number(z)?)),
        _ => None,
    }
}
