//! How files are read.

use std::path::PathBuf;

#[cfg(any(
    feature = "ply",
    feature = "obj",
    feature = "hair",
    feature = "vol",
    feature = "nvdb",
    feature = "vdb"
))]
use glam::DMat3;

use super::LoadError;

/// How files are read. [`Default`] is strict, in metres, with +Y up.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// Leaves out what cannot be read, with a note, also if geometry is lost
    /// that way: glTF extensions that are required or that carry geometry.
    pub lenient: bool,
    /// A folder from which, with all below it, a scene file may take buffers and
    /// images too. Paths are those in the file, relative to its own folder.
    pub assets: Option<PathBuf>,
    /// Length of the unit of PLY, OBJ, HAIR, VOL, NanoVDB and OpenVDB files, m; 1e-9 to 1e9. glTF
    /// is in metres, and any other unit is an error there.
    pub unit: f64,
    /// The axis that points up in PLY, OBJ, HAIR, VOL, NanoVDB and OpenVDB files. It is +Y in
    /// glTF, and any other is an error there.
    pub up: UpAxis,
}

/// The axis that points up in a right-handed file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum UpAxis {
    /// (x, y, z) becomes (−y, x, z).
    X,
    /// Nothing is turned.
    #[default]
    Y,
    /// (x, y, z) becomes (x, z, −y).
    Z,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            lenient: false,
            assets: None,
            unit: 1.0,
            up: UpAxis::Y,
        }
    }
}

impl LoadOptions {
    /// # Errors
    /// [`LoadError::BadValue`] for a unit that is none.
    pub(super) fn check(&self) -> Result<(), LoadError> {
        if (1e-9..=1e9).contains(&self.unit) {
            return Ok(());
        }
        Err(LoadError::bad_value(
            "the unit of length",
            self.unit,
            "1e-9 to 1e9 m",
        ))
    }

    /// Nothing else than what glTF says of its unit and its axes.
    ///
    /// # Errors
    /// [`LoadError::BadValue`] for another unit or axis.
    #[cfg(feature = "gltf")]
    pub(super) fn check_gltf(&self) -> Result<(), LoadError> {
        if self.unit != 1.0 {
            let what = "the unit of length of a glTF file";
            return Err(LoadError::bad_value(
                what,
                self.unit,
                "1: glTF is in metres",
            ));
        }
        if self.up != UpAxis::Y {
            let (what, axis) = ("the axis that points up", format!("+{:?}", self.up));
            return Err(LoadError::bad_value(what, axis, "+Y, as glTF has it"));
        }
        Ok(())
    }
}

impl UpAxis {
    /// From the file's axes to the scene's.
    #[cfg(any(
        feature = "ply",
        feature = "obj",
        feature = "hair",
        feature = "vol",
        feature = "nvdb",
        feature = "vdb"
    ))]
    pub(super) fn rotation(self) -> DMat3 {
        let columns = match self {
            Self::X => [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            Self::Y => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Self::Z => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        };
        DMat3::from_cols_array_2d(&columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(any(
        feature = "ply",
        feature = "obj",
        feature = "hair",
        feature = "vol",
        feature = "nvdb",
        feature = "vdb"
    ))]
    #[test]
    fn the_up_axis_becomes_y_without_mirroring() {
        use glam::DVec3;

        for (up, axis) in [
            (UpAxis::X, DVec3::X),
            (UpAxis::Y, DVec3::Y),
            (UpAxis::Z, DVec3::Z),
        ] {
            let rotation = up.rotation();
            assert_eq!(rotation * axis, DVec3::Y);
            assert_eq!(rotation.determinant(), 1.0);
        }
        let point = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(UpAxis::X.rotation() * point, DVec3::new(-2.0, 1.0, 3.0));
        assert_eq!(UpAxis::Z.rotation() * point, DVec3::new(1.0, 3.0, -2.0));
    }

    #[test]
    fn units_that_are_none_are_refused() {
        for unit in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e10] {
            let options = LoadOptions {
                unit,
                ..LoadOptions::default()
            };
            let error = options.check().unwrap_err().to_string();
            assert!(error.contains("unit"), "{error}");
        }
        assert!(LoadOptions::default().check().is_ok());
    }
}
