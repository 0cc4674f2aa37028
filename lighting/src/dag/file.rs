//! The grids of one light as one file.
//!
//! A light with one grid has the file of that grid. Six are put one after the
//! other behind a head: [`MAGIC`], and the length of each in bytes as a
//! little-endian number of 64 bits.

use shadow_dag::{FileError, ShadowDag};

use super::{BakedError, BakedShadow};

/// What six grids begin with.
const MAGIC: [u8; 8] = *b"CPVSCUBE";

/// Bytes in front of the first of six grids.
const HEAD: usize = MAGIC.len() + 6 * 8;

impl<B: AsRef<[u8]>> BakedShadow<B> {
    /// The file of these shadows.
    pub fn to_bytes(&self) -> Vec<u8> {
        if let [grid] = self.grids() {
            return grid.as_bytes().to_vec();
        }
        let grids = self.grids().iter().map(ShadowDag::as_bytes);
        let lengths = grids
            .clone()
            .flat_map(|grid| (grid.len() as u64).to_le_bytes());
        let head = MAGIC.into_iter().chain(lengths);
        head.chain(grids.flatten().copied()).collect()
    }
}

impl<'a> BakedShadow<&'a [u8]> {
    /// Takes the bytes of a file for shadows, where they are. Reads all of them
    /// once: afterwards no question can fail.
    ///
    /// # Errors
    /// [`BakedError`] if they are not a whole and consistent file, or do not
    /// say where in the world the grids are; or if these differ in resolution.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, BakedError> {
        let read = |grid, bytes| {
            ShadowDag::from_bytes(bytes).map_err(|error| BakedError::File { grid, error })
        };
        if !bytes.starts_with(&MAGIC) {
            return Self::new(vec![read(0, bytes)?]);
        }
        let given = bytes.len() as u64;
        let truncated = |expected| BakedError::File {
            grid: 0,
            error: FileError::Truncated { given, expected },
        };
        let head = bytes.get(MAGIC.len()..HEAD).ok_or(truncated(HEAD as u64))?;
        let mut rest = &bytes[HEAD..];
        let mut grids = Vec::with_capacity(6);
        for (number, length) in head.as_chunks().0.iter().enumerate() {
            let length = u64::from_le_bytes(*length);
            let part = usize::try_from(length)
                .ok()
                .and_then(|length| rest.split_at_checked(length));
            let (grid, after) = part.ok_or_else(|| {
                let before = given - rest.len() as u64;
                truncated(before.saturating_add(length))
            })?;
            grids.push(read(number, grid)?);
            rest = after;
        }
        if !rest.is_empty() {
            let error = FileError::TooLong {
                given,
                expected: given - rest.len() as u64,
            };
            return Err(BakedError::File { grid: 5, error });
        }
        Self::new(grids)
    }
}
