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
        if !FIELDS.contains(&name.as_str()) {
            return Err(LoadError::bad_value(
                "a field of \"medium\" in the extras",
                printable(name),
                "sigma_s, sigma_a, phase, g, k, weight, diameter or box",
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
    let medium = Medium::new(
        coefficient("sigma_s")?,
        coefficient("sigma_a")?,
        phase(value)?,
    )?;
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

const FIELDS: [&str; 8] = [
    "sigma_s", "sigma_a", "phase", "g", "k", "weight", "diameter", "box",
];

fn phase(fields: &Value) -> Result<PhaseFunction, LoadError> {
    let name = fields.get("phase");
    // Parameters that the function does not have.
    let only = |own: &[&str]| {
        for field in ["g", "k", "weight", "diameter"] {
            if let (false, Some(value)) = (own.contains(&field), fields.get(field)) {
                return Err(bad(field, value, "nothing with this phase function"));
            }
        }
        Ok(())
    };
    let value = |field| fields.get(field).unwrap_or(&Value::Null);
    let is_asymmetry = |parameter: &f32| parameter.abs() < 1.0;
    let parameter = |field| {
        let expected = "a number between -1 and 1, both excluded";
        let parameter = number(value(field)).filter(is_asymmetry);
        parameter.ok_or_else(|| bad(field, value(field), expected))
    };
    match name.map_or(Some("isotropic"), Value::as_str) {
        Some("isotropic") => {
            only(&[])?;
            Ok(PhaseFunction::Isotropic)
        }
        Some("rayleigh") => {
            only(&[])?;
            Ok(PhaseFunction::Rayleigh)
        }
        Some("henyey-greenstein") => {
            only(&["g"])?;
            Ok(PhaseFunction::HenyeyGreenstein { g: parameter("g")? })
        }
        Some("cornette-shanks") => {
            only(&["g"])?;
            Ok(PhaseFunction::CornetteShanks { g: parameter("g")? })
        }
        Some("schlick") => {
            only(&["k"])?;
            Ok(PhaseFunction::Schlick { k: parameter("k")? })
        }
        Some("double-henyey-greenstein") => {
            only(&["g", "weight"])?;
            let g = match value("g").as_array().map(Vec::as_slice) {
                Some([first, second]) => number(first).zip(number(second)),
                _ => None,
            };
            let g = g.filter(|(first, second)| is_asymmetry(first) && is_asymmetry(second));
            let weight = number(value("weight")).filter(|weight| (0.0..=1.0).contains(weight));
            match (g, weight) {
                (None, _) => Err(bad(
                    "g",
                    value("g"),
                    "two numbers between -1 and 1, both excluded",
                )),
                (_, None) => Err(bad("weight", value("weight"), "a number from 0 to 1")),
                (Some((first, second)), Some(weight)) => {
                    let g = [first, second];
                    Ok(PhaseFunction::DoubleHenyeyGreenstein { g, weight })
                }
            }
        }
        Some("droplets") => {
            only(&["diameter"])?;
            let phase = number(value("diameter")).map(PhaseFunction::droplets);
            phase
                .and_then(Result::ok)
                .ok_or_else(|| bad("diameter", value("diameter"), "a number from 5 to 50"))
        }
        _ => Err(bad(
            "phase",
            name.unwrap_or(&Value::Null),
            "\"isotropic\", \"rayleigh\", \"henyey-greenstein\", \"cornette-shanks\", \"schlick\", \"double-henyey-greenstein\" or \"droplets\"",
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
