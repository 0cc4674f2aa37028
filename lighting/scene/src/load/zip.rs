//! ZLIB data of a length that is known.

use super::LoadError;

/// What is in `packed`, which has to be `length` bytes.
pub(super) fn unpacked(what: &str, packed: &[u8], length: usize) -> Result<Vec<u8>, LoadError> {
    miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(packed, length)
        .ok()
        .filter(|unpacked| unpacked.len() == length)
        .ok_or_else(|| {
            let value = format!("{} bytes", packed.len());
            let expected = "ZLIB data of the length that the file tells";
            LoadError::bad_value(what, value, expected)
        })
}
