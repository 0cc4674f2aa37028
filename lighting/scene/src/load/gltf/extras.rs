//! What the `extras` of a document say of shadows, of what moves, and of lights.

use gltf_json::Value;

use crate::Falloff;
use crate::load::LoadError;

/// Whether `castsShadow` is false; `None` if it is not there.
pub(super) fn no_shadow(extras: Option<&Value>, owner: &str) -> Result<Option<bool>, LoadError> {
    let casts = truth(extras, "castsShadow", owner)?;
    Ok(casts.map(|casts| !casts))
}

/// Whether `dynamic` is true; `None` if it is not there.
pub(super) fn dynamic(extras: Option<&Value>, owner: &str) -> Result<Option<bool>, LoadError> {
    truth(extras, "dynamic", owner)
}

fn truth(extras: Option<&Value>, field: &str, owner: &str) -> Result<Option<bool>, LoadError> {
    let Some(value) = extras.and_then(|extras| extras.get(field)) else {
        return Ok(None);
    };
    // Some editors know no truth values.
    let known = value.as_bool().or_else(|| match value.as_u64() {
        Some(number @ (0 | 1)) => Some(number == 1),
        _ => None,
    });
    match known {
        Some(known) => Ok(Some(known)),
        None => Err(LoadError::bad_value(
            format!("{field} in the extras of {owner}"),
            kind(value),
            "true or false",
        )),
    }
}

/// The image in front of a spotlight and the angle it is turned by.
pub(super) fn cookie(extras: &Value, owner: &str) -> Result<Option<(u32, f32)>, LoadError> {
    let Some(cookie) = extras.get("cookie") else {
        return Ok(None);
    };
    let image = cookie.get("image").and_then(Value::as_u64);
    let image = image.and_then(|image| u32::try_from(image).ok());
    let rotation = match cookie.get("rotation") {
        None => Some(0.0),
        Some(value) => number(value),
    };
    match image.zip(rotation) {
        Some(found) => Ok(Some(found)),
        None => Err(LoadError::bad_value(
            format!("the cookie in the extras of {owner}"),
            kind(cookie),
            "an object with the index of an image and, if need be, a rotation in radians",
        )),
    }
}

/// The angle that a directional light spans in the sky.
pub(super) fn angular_diameter(extras: &Value, owner: &str) -> Result<Option<f32>, LoadError> {
    let Some(value) = extras.get("angularDiameter") else {
        return Ok(None);
    };
    match number(value).filter(|d| (0.0..=std::f32::consts::FRAC_PI_2).contains(d)) {
        Some(diameter) => Ok(Some(diameter)),
        None => Err(LoadError::bad_value(
            format!("angularDiameter in the extras of {owner}"),
            number(value).map_or_else(|| kind(value).into(), |number| number.to_string()),
            "0 to pi/2 rad",
        )),
    }
}

/// How a light ends at its range.
pub(super) fn falloff(extras: &Value, owner: &str) -> Result<Option<Falloff>, LoadError> {
    let Some(value) = extras.get("falloff") else {
        return Ok(None);
    };
    match value.as_str() {
        Some("smooth") => Ok(Some(Falloff::Smooth)),
        Some("hard") => Ok(Some(Falloff::Hard)),
        _ => Err(LoadError::bad_value(
            format!("falloff in the extras of {owner}"),
            kind(value),
            "\"smooth\" or \"hard\"",
        )),
    }
}

/// A number that is finite as f32.
pub(super) fn number(value: &Value) -> Option<f32> {
    let number = value.as_f64().map(|number| number as f32);
    number.filter(|number| number.is_finite())
}

/// What a value is, in place of its text.
pub(super) fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a truth value",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "another object",
    }
}
