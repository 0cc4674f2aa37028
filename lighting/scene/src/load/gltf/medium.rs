//! The media in the `extras` of a document.

use glam::{DVec3, Vec3};
use gltf_json::{Extras, Value};

use super::extras::{kind, number};
use crate::load::LoadError;
use crate::load::error::printable;
use crate::{Bounds, HeightFog, Medium, PhaseFunction};

/// The medium that `extras` describe, if they do, in a scene that is moved by
/// `offset`.
pub(super) fn medium(extras: &Extras, offset: DVec3) -> Result<Option<Medium>, LoadError> {
    let Some(extras) = parsed(extras)? else {
        return Ok(None);
    };
    let Some(fields) = Fields::of(&extras, "medium", &["sigma_s", "sigma_a", "box"])? else {
        return Ok(None);
    };
    let medium = Medium::new(
        fields.coefficient("sigma_s")?,
        fields.coefficient("sigma_a")?,
        fields.phase()?,
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
        None => Err(fields.bad(
            "box",
            value,
            "two corners [x, y, z], the first below the second on each axis",
        )),
    }
}

/// The fog that thins out with altitude that `extras` describe, if they do.
pub(super) fn height_fog(extras: &Extras, offset: DVec3) -> Result<Option<HeightFog>, LoadError> {
    let Some(extras) = parsed(extras)? else {
        return Ok(None);
    };
    let own = ["sigma_s", "sigma_a", "altitude", "scaleHeight"];
    let Some(fields) = Fields::of(&extras, "heightFog", &own)? else {
        return Ok(None);
    };
    let length = |name: &str, missing: Option<f32>| {
        let value = fields.get(name);
        let length = value.map_or(missing, number);
        let bad = || fields.bad(name, value.unwrap_or(&Value::Null), "a number of metres");
        length.ok_or_else(bad)
    };
    let altitude = f64::from(length("altitude", Some(0.0))?) - offset.y;
    let fog = HeightFog::new(
        fields.coefficient("sigma_s")?,
        fields.coefficient("sigma_a")?,
        altitude as f32,
        length("scaleHeight", None)?,
        fields.phase()?,
    )?;
    Ok(Some(fog))
}

/// As JSON; the library leaves them as text.
fn parsed(extras: &Extras) -> Result<Option<Value>, LoadError> {
    let parse = |extras: &str| {
        gltf_json::deserialize::from_str(extras).map_err(|error| LoadError::Json(error.to_string()))
    };
    extras
        .as_ref()
        .map(|extras| parse(extras.get()))
        .transpose()
}

/// The fields of an object in the extras that describes a medium.
pub(super) struct Fields<'a> {
    owner: &'static str,
    value: &'a Value,
}

/// Those of a phase function.
pub(super) const OF_PHASE: [&str; 5] = ["phase", "g", "k", "weight", "diameter"];

impl<'a> Fields<'a> {
    /// The object called `owner`, if there is one; it has fields of its own and those of
    /// a phase function.
    pub(super) fn of(
        extras: &'a Value,
        owner: &'static str,
        own: &[&str],
    ) -> Result<Option<Self>, LoadError> {
        let Some(value) = extras.get(owner) else {
            return Ok(None);
        };
        let fields = Self { owner, value };
        let Some(object) = value.as_object() else {
            return Err(fields.bad("", value, "an object"));
        };
        for name in object.keys() {
            if !own.contains(&name.as_str()) && !OF_PHASE.contains(&name.as_str()) {
                return Err(LoadError::bad_value(
                    format!("a field of \"{owner}\" in the extras"),
                    printable(name),
                    match owner {
                        "medium" => "sigma_s, sigma_a, phase, g, k, weight, diameter or box",
                        "heightFog" => {
                            "sigma_s, sigma_a, altitude, scaleHeight, phase, g, k, weight or diameter"
                        }
                        _ => "uri, albedo, emission, phase, g, k, weight or diameter",
                    },
                ));
            }
        }
        let is_coefficient = |name: &&str| name.starts_with("sigma");
        let mut coefficients = own.iter().filter(|name| is_coefficient(name)).peekable();
        if coefficients.peek().is_some() && !coefficients.any(|name| object.contains_key(*name)) {
            return Err(fields.bad("", value, "sigma_s or sigma_a in it"));
        }
        Ok(Some(fields))
    }

    /// One of them, if it is there.
    pub(super) fn get(&self, name: &str) -> Option<&'a Value> {
        self.value.get(name)
    }

    /// One number for all colour channels, or one for each; 0 if it is missing.
    fn coefficient(&self, name: &str) -> Result<Vec3, LoadError> {
        self.colour(name)?.map_or(Ok(Vec3::ZERO), Ok)
    }

    /// The same, if it is there.
    pub(super) fn colour(&self, name: &str) -> Result<Option<Vec3>, LoadError> {
        let value = self.get(name);
        value.map(|value| self.as_colour(name, value)).transpose()
    }

    /// A value of the field `name` as a colour.
    pub(super) fn as_colour(&self, name: &str, value: &Value) -> Result<Vec3, LoadError> {
        let colour = number(value).map(Vec3::splat).or_else(|| vector(value));
        colour
            .filter(|colour| colour.min_element() >= 0.0)
            .ok_or_else(|| self.bad(name, value, "one number or three, finite, not negative"))
    }

    /// The phase function, isotropic if none is named.
    pub(super) fn phase(&self) -> Result<PhaseFunction, LoadError> {
        phase(self.value, self.owner)
    }

    /// The error of a field.
    pub(super) fn bad(&self, field: &str, value: &Value, expected: &'static str) -> LoadError {
        bad(self.owner, field, value, expected)
    }
}

fn phase(fields: &Value, owner: &str) -> Result<PhaseFunction, LoadError> {
    let bad = |field: &str, value: &Value, expected| bad(owner, field, value, expected);
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

fn bad(owner: &str, field: &str, value: &Value, expected: &'static str) -> LoadError {
    let dot = if field.is_empty() { "" } else { "." };
    LoadError::bad_value(
        format!("\"{owner}{dot}{field}\" in the extras"),
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
