//! Values on the command line that are more than one number.

use glam::{DVec3, Vec3};
use lighting::scene::Bounds;

/// The largest side of a picture.
pub(crate) const MAX_SIDE: u32 = 16384;

/// Pictures of more pixels are refused: their buffers would take more than a
/// few GiB. 8K (7680 × 4320) is below.
const MAX_PIXELS: usize = 1 << 25;

/// Width and height of a picture, `320x180`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Size {
    pub(crate) fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Both sides halved, as far as they can be.
    pub(crate) fn halved(self) -> Self {
        Self {
            width: (self.width / 2).max(1),
            height: (self.height / 2).max(1),
        }
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

pub(crate) fn size(text: &str) -> Result<Size, String> {
    let expected = "expected WIDTHxHEIGHT, such as 320x180";
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or(expected)?;
    let side = |text: &str| text.trim().parse::<u32>().map_err(|_| expected);
    let (width, height) = (side(width)?, side(height)?);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(format!("both sides must be 1 to {MAX_SIDE} pixels"));
    }
    let size = Size { width, height };
    let pixels = size.pixels();
    if pixels > MAX_PIXELS {
        return Err(format!(
            "{pixels} pixels, at most {MAX_PIXELS} are supported"
        ));
    }
    Ok(size)
}

/// A square number of rays per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Square {
    /// Its root.
    pub(crate) side: u32,
}

pub(crate) fn square(text: &str) -> Result<Square, String> {
    let expected = "expected a square number from 1 to 1024, such as 4 or 16";
    let number: u32 = text.trim().parse().map_err(|_| expected)?;
    let side = number.isqrt();
    if side * side != number || !(1..=32).contains(&side) {
        return Err(expected.into());
    }
    Ok(Square { side })
}

impl Size {
    /// The picture of all rays: `rays` per pixel.
    pub(crate) fn of_rays(self, rays: Square) -> Result<Self, String> {
        let size = format!("{}x{}", self.width * rays.side, self.height * rays.side);
        let rays = rays.side * rays.side;
        self::size(&size).map_err(|why| format!("{rays} rays per pixel make {size}: {why}"))
    }
}

/// A point in space.
pub(crate) fn point(text: &str) -> Result<DVec3, String> {
    match doubles(text)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err("expected a point as X,Y,Z".into()),
    }
}

/// Where a camera stands, what is in the middle of its picture, and its vertical
/// field of view in degrees, if that is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewpoint {
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    pub(crate) degrees: Option<f64>,
}

pub(crate) fn viewpoint(text: &str) -> Result<Viewpoint, String> {
    let numbers = doubles(text)?;
    let (points, degrees) = match numbers[..] {
        [.., degrees] if numbers.len() == 7 => (&numbers[..6], Some(degrees)),
        _ => (&numbers[..], None),
    };
    let [a, b, c, x, y, z] = points[..] else {
        return Err("expected a camera as X,Y,Z,X,Y,Z or X,Y,Z,X,Y,Z,DEGREES".into());
    };
    if degrees.is_some_and(|degrees| !(1e-3..=170.0).contains(&degrees)) {
        return Err("expected a field of view from 0.001 to 170 degrees".into());
    }
    Ok(Viewpoint {
        eye: DVec3::new(a, b, c),
        target: DVec3::new(x, y, z),
        degrees,
    })
}

/// Metres in the unit of a file.
pub(crate) fn unit(text: &str) -> Result<f64, String> {
    let named = [
        ("mm", 0.001),
        ("cm", 0.01),
        ("m", 1.0),
        ("km", 1000.0),
        ("in", 0.0254),
        ("ft", 0.3048),
    ];
    if let Some((_, metres)) = named.iter().find(|(name, _)| *name == text.trim()) {
        return Ok(*metres);
    }
    let metres: f64 = (text.trim().parse())
        .map_err(|_| "expected mm, cm, m, km, in, ft or a number of metres")?;
    if !(1e-9..=1e9).contains(&metres) {
        return Err("expected 1e-9 to 1e9 metres".into());
    }
    Ok(metres)
}

/// A length above 0 in metres, or with a unit behind the number: `1cm`.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("mm", 0.001), ("cm", 0.01), ("m", 1.0)];
    let (number, metres) = (units.iter())
        .find_map(|(name, metres)| Some((text.strip_suffix(name)?, *metres)))
        .unwrap_or((text, 1.0));
    let length = number.trim().parse::<f64>().map(|number| number * metres);
    match length {
        Ok(length) if length > 0.0 && length < f64::INFINITY => Ok(length),
        _ => Err("expected a length above 0, such as 1cm, 5mm or 0.02 (metres)".into()),
    }
}

/// A number of voxels from 0.
pub(crate) fn bias(text: &str) -> Result<f32, String> {
    let bias = finite(text)?;
    if bias >= 0.0 {
        return Ok(bias);
    }
    Err("expected a number of voxels from 0".into())
}

/// A coefficient per channel: one number, or three separated by commas.
pub(crate) fn coefficient(text: &str) -> Result<Vec3, String> {
    let numbers = numbers(text)?;
    let value = match numbers[..] {
        [all] => Vec3::splat(all),
        [r, g, b] => Vec3::new(r, g, b),
        _ => return Err("expected a number, or three as R,G,B".into()),
    };
    if !(value.min_element() >= 0.0) {
        return Err("must not be negative".into());
    }
    Ok(value)
}

pub(crate) fn bounds(text: &str) -> Result<Bounds, String> {
    let numbers = numbers(text)?;
    let [ax, ay, az, bx, by, bz] = numbers[..] else {
        return Err("expected two corners as X,Y,Z,X,Y,Z".into());
    };
    Bounds::new(Vec3::new(ax, ay, az), Vec3::new(bx, by, bz)).map_err(|error| error.to_string())
}

/// A duration above 0, in seconds, at most a day.
pub(crate) fn duration(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number of seconds")?;
    if !(value > 0.0 && value <= 86400.0) {
        return Err("expected above 0 and at most 86400 seconds".into());
    }
    Ok(value)
}

/// An error that a picture may have: a percentage, or a share.
pub(crate) fn error_target(text: &str) -> Result<f64, String> {
    let expected = "expected an error above 0 and at most 100 %, such as 1% or 0.01";
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let value: f64 = number.trim().parse().map_err(|_| expected)?;
    let share = value * unit;
    match share > 0.0 && share <= 1.0 {
        true => Ok(share),
        false => Err(expected.into()),
    }
}

/// A time that a frame may take, in seconds unless it has a unit.
pub(crate) fn time_target(text: &str) -> Result<f64, String> {
    let expected = "expected a time above 0 and at most a day, such as 16ms, 2s or 0.016";
    let units = [("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("s", 1.0)];
    let text = text.trim();
    let with_unit = units
        .iter()
        .find_map(|(name, unit)| Some((text.strip_suffix(name)?, *unit)));
    let (number, unit) = with_unit.unwrap_or((text, 1.0));
    let value: f64 = number.trim().parse().map_err(|_| expected)?;
    let seconds = value * unit;
    match seconds > 0.0 && seconds <= 86_400.0 {
        true => Ok(seconds),
        false => Err(expected.into()),
    }
}

/// The relative error that the reference may have per pixel.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number")?;
    if !(1e-10..=1e-2).contains(&value) {
        return Err("expected 1e-10 to 1e-2".into());
    }
    Ok(value)
}

pub(crate) fn finite(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| "expected a number")?;
    if !value.is_finite() {
        return Err("expected a finite number".into());
    }
    Ok(value)
}

/// The mean cosine of the Henyey-Greenstein phase function.
pub(crate) fn mean_cosine(text: &str) -> Result<f32, String> {
    let value = finite(text)?;
    if !(value.abs() < 1.0) {
        return Err("expected a number between -1 and 1, both excluded".into());
    }
    Ok(value)
}

/// Finite numbers, separated by commas. Coordinates far from the origin need their digits.
pub(crate) fn doubles(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected finite numbers, separated by commas".to_owned()),
    };
    text.split(',').map(number).collect()
}

fn numbers(text: &str) -> Result<Vec<f32>, String> {
    text.split(',').map(|part| finite(part.trim())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked() {
        let expected = Size {
            width: 320,
            height: 180,
        };
        assert_eq!(size("320x180"), Ok(expected));
        assert_eq!(size(" 320 × 180"), Ok(expected));
        for bad in [
            "",
            "0x0",
            "1x0",
            "16385x1",
            "-1x4",
            "3",
            "axb",
            "99999999999x1",
            "16384x16384",
        ] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_must_be_in_their_domain() {
        assert_eq!(coefficient("0.5"), Ok(Vec3::splat(0.5)));
        assert_eq!(coefficient("1,2,3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
        for bad in ["", "-1", "nan", "inf", "1,2", "1,-2,3", "1e99"] {
            assert!(coefficient(bad).is_err(), "{bad}");
        }
        assert!(bounds("0,0,0,1,1,1").is_ok());
        for bad in ["0,0,0", "0,0,0,1,1,0", "0,0,0,1,1,nan"] {
            assert!(bounds(bad).is_err(), "{bad}");
        }
        assert!(duration("10").is_ok());
        assert!(
            ["0", "-1", "nan", "1e9"]
                .iter()
                .all(|t| duration(t).is_err())
        );
        assert!(["0", "nan", "1"].iter().all(|t| tolerance(t).is_err()));
        assert!(["1", "-1", "nan"].iter().all(|t| mean_cosine(t).is_err()));
    }

    #[test]
    fn lengths_have_units() {
        for (text, metres) in [("1cm", 0.01), ("5 mm", 0.005), ("0.02", 0.02), ("2m", 2.0)] {
            assert_eq!(length(text), Ok(metres), "{text}");
        }
        for bad in ["", "cm", "0", "-1cm", "nan", "inf", "1km", "1 2"] {
            assert!(length(bad).is_err(), "{bad}");
        }
        assert_eq!(bias("0"), Ok(0.0));
        assert!(bias("-0.5").is_err() && bias("nan").is_err());
    }

    #[test]
    fn rays_per_pixel_are_squares() {
        assert_eq!(square("1"), Ok(Square { side: 1 }));
        assert_eq!(square("16"), Ok(Square { side: 4 }));
        for bad in ["0", "2", "-4", "1089", "4.0", "", "99999999999"] {
            assert!(square(bad).is_err(), "{bad}");
        }
        let picture = size("960x540").unwrap();
        let rays = picture.of_rays(Square { side: 2 }).unwrap();
        assert_eq!(rays.to_string(), "1920x1080");
        let error = picture.of_rays(Square { side: 32 }).unwrap_err();
        assert!(error.contains("1024 rays per pixel"), "{error}");
    }

    #[test]
    fn points_units_and_cameras_are_checked() {
        assert_eq!(point("1,2,-3"), Ok(DVec3::new(1.0, 2.0, -3.0)));
        for bad in ["", "1,2", "1,2,nan", "1,2,3,4", "1,2,inf"] {
            assert!(point(bad).is_err(), "{bad}");
        }
        let camera = viewpoint("0,1,5, 0,1,0").unwrap();
        assert_eq!(
            (camera.eye.z, camera.target.y, camera.degrees),
            (5.0, 1.0, None)
        );
        assert_eq!(viewpoint("0,1,5,0,1,0,30").unwrap().degrees, Some(30.0));
        for bad in [
            "",
            "1,2,3",
            "0,0,0,0,0,1,0",
            "0,0,0,0,0,1,180",
            "1,2,3,4,5,6,7,8",
        ] {
            assert!(viewpoint(bad).is_err(), "{bad}");
        }
        assert_eq!(unit("cm"), Ok(0.01));
        assert_eq!(unit("2.5"), Ok(2.5));
        for bad in ["", "0", "-1", "nan", "inf", "1e10", "yard"] {
            assert!(unit(bad).is_err(), "{bad}");
        }
    }
}
