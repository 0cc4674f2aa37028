//! Frames of Blosc 1, as OpenVDB writes them: LZ4 or ZLIB, with the bytes of numbers
//! shuffled or not.
//!
//! A frame is a header of 16 bytes, a table of where its blocks begin, and the blocks. Each
//! block is one stream, or one for each byte of a number, with its length in front.

use std::borrow::Cow;

use super::zip;
use crate::load::LoadError;
use crate::load::words::Words;

/// Bits of the header's flags; above them the codec.
const SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const UNDIVIDED: u8 = 16;

/// Blocks of larger numbers, or of fewer numbers, are one stream.
const MOST_STREAMS: usize = 16;
const LEAST_NUMBERS: usize = 128;

const WHAT: &str = "a Blosc frame of an OpenVDB grid";

/// What is in a frame, which has to be `length` bytes.
pub(super) fn unpacked(frame: &[u8], length: usize) -> Result<Cow<'_, [u8]>, LoadError> {
    let mut words = Words::new(frame);
    let [_, _, flags, number] = words.item(WHAT)?;
    let whole = words.u32(WHAT)? as usize;
    let block = words.u32(WHAT)? as usize;
    words.item::<4>(WHAT)?;
    if whole != length {
        return Err(LoadError::bad_value(WHAT, whole, "the bytes of its node"));
    }
    if flags & STORED != 0 {
        return Ok(Cow::Borrowed(words.bytes(WHAT, length as u64)?));
    }
    if length == 0 {
        return Ok(Cow::Borrowed(&[]));
    }
    if flags & BITS_SHUFFLED != 0 {
        return Err(LoadError::Unsupported("Blosc that shuffles bits".into()));
    }
    let codec = Codec::of(flags >> 5)?;
    let number = usize::from(number);
    if number == 0 || block == 0 {
        let what = "the numbers and blocks of a Blosc frame";
        let value = format!("{number} and {block} bytes");
        return Err(LoadError::bad_value(what, value, "at least one byte each"));
    }
    let places = words.items::<4>(WHAT, length.div_ceil(block) as u64)?;
    let mut unpacked = vec![0; length];
    let mut shuffled = vec![0; block.min(length)];
    for (place, out) in places.zip(unpacked.chunks_mut(block)) {
        let is_divided = flags & UNDIVIDED == 0
            && number <= MOST_STREAMS
            && block / number >= LEAST_NUMBERS
            && out.len() == block;
        let streams = if is_divided { number } else { 1 };
        let place = u32::from_le_bytes(place) as usize;
        let mut words = Words::new(frame.get(place..).unwrap_or_default());
        let is_shuffled = flags & SHUFFLED != 0 && number > 1;
        let length = out.len();
        let target = match is_shuffled {
            true => &mut shuffled[..length],
            false => &mut *out,
        };
        for stream in target.chunks_mut(length.div_ceil(streams)) {
            let packed = words.u32(WHAT)?;
            let packed = words.bytes(WHAT, packed.into())?;
            if packed.len() == stream.len() {
                stream.copy_from_slice(packed);
            } else {
                codec.unpack(packed, stream)?;
            }
        }
        if is_shuffled {
            unshuffle(&shuffled[..length], number, out);
        }
    }
    Ok(Cow::Owned(unpacked))
}

/// Puts the bytes of each number together again, the first ones of all of which are in
/// front of the second ones; what is left over is at the end as it is.
fn unshuffle(shuffled: &[u8], number: usize, out: &mut [u8]) {
    let count = out.len() / number;
    for (i, bytes) in out.chunks_exact_mut(number).enumerate() {
        for (j, byte) in bytes.iter_mut().enumerate() {
            *byte = shuffled[j * count + i];
        }
    }
    let rest = count * number;
    out[rest..].copy_from_slice(&shuffled[rest..]);
}

#[derive(Debug, Clone, Copy)]
enum Codec {
    Lz4,
    Zlib,
}

impl Codec {
    fn of(number: u8) -> Result<Self, LoadError> {
        let unsupported = |name: &str| Err(LoadError::Unsupported(format!("Blosc with {name}")));
        match number {
            0 => unsupported("BloscLZ"),
            1 => Ok(Self::Lz4),
            2 => unsupported("Snappy"),
            3 => Ok(Self::Zlib),
            4 => unsupported("Zstandard"),
            _ => Err(LoadError::bad_value("the Blosc codec", number, "0 to 4")),
        }
    }

    /// Fills `out`.
    fn unpack(self, packed: &[u8], out: &mut [u8]) -> Result<(), LoadError> {
        match self {
            Self::Lz4 => match lz4_flex::block::decompress_into(packed, out) {
                Ok(length) if length == out.len() => Ok(()),
                _ => {
                    let value = format!("{} bytes", packed.len());
                    let expected = "LZ4 data of the length that the file tells";
                    Err(LoadError::bad_value(WHAT, value, expected))
                }
            },
            Self::Zlib => {
                out.copy_from_slice(&zip::unpacked(WHAT, packed, out.len())?);
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of numbers of 4 bytes, in blocks of this length, each as one stream or as
    /// four, which `pack` packs.
    fn frame(bytes: &[u8], block: usize, flags: u8, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
        let (mut table, mut streams) = (Vec::new(), Vec::new());
        let first = 16 + 4 * bytes.len().div_ceil(block);
        for block_bytes in bytes.chunks(block) {
            table.extend(((first + streams.len()) as u32).to_le_bytes());
            let count = block_bytes.len() / 4;
            let mut shuffled = block_bytes.to_vec();
            if flags & SHUFFLED != 0 {
                for i in 0..4 * count {
                    shuffled[i % 4 * count + i / 4] = block_bytes[i];
                }
            }
            let is_divided = flags & UNDIVIDED == 0 && block_bytes.len() == block;
            let parts = if is_divided { 4 } else { 1 };
            for stream in shuffled.chunks(block_bytes.len() / parts) {
                let mut packed = pack(stream);
                if packed.len() >= stream.len() {
                    packed = stream.to_vec();
                }
                streams.extend((packed.len() as u32).to_le_bytes());
                streams.extend(packed);
            }
        }
        let mut frame = vec![2, 1, flags, 4];
        let whole = first + streams.len();
        for length in [bytes.len(), block, whole] {
            frame.extend((length as u32).to_le_bytes());
        }
        [frame, table, streams].concat()
    }

    fn lz4(bytes: &[u8]) -> Vec<u8> {
        lz4_flex::block::compress(bytes)
    }

    fn zlib(bytes: &[u8]) -> Vec<u8> {
        miniz_oxide::deflate::compress_to_vec_zlib(bytes, 6)
    }

    #[test]
    fn blocks_streams_and_what_is_left_over_come_out_as_they_went_in() {
        let bytes: Vec<u8> = (0..3002_u32).map(|i| (i * i / 700) as u8).collect();
        for shuffle in [0, SHUFFLED] {
            for divide in [0, UNDIVIDED] {
                let flags = shuffle | divide;
                for frame in [
                    frame(&bytes, 1024, flags | 1 << 5, lz4),
                    frame(&bytes, 1024, flags | 3 << 5, zlib),
                    frame(&bytes, 1024, flags | 1 << 5, <[u8]>::to_vec),
                ] {
                    assert!(unpacked(&frame, bytes.len()).unwrap() == bytes, "{flags}");
                }
            }
        }
        let stored = [&[2, 1, STORED, 4], &[5_u8, 0, 0, 0][..], &[0; 8], b"hello"].concat();
        assert_eq!(&*unpacked(&stored, 5).unwrap(), b"hello");
        assert_eq!(&*unpacked(&[0; 16], 0).unwrap(), b"");
    }

    #[test]
    fn bad_frames_are_refused_with_their_cause() {
        let bytes = [7; 2048];
        let good = frame(&bytes, 1024, SHUFFLED | UNDIVIDED | 1 << 5, lz4);
        let with = |place: usize, byte: u8| {
            let mut frame = good.clone();
            frame[place] = byte;
            frame
        };
        for (frame, cause) in [
            (with(2, UNDIVIDED), "BloscLZ"),
            (with(2, UNDIVIDED | 2 << 5), "Snappy"),
            (with(2, UNDIVIDED | 3 << 5), "ZLIB"),
            (with(2, UNDIVIDED | 4 << 5), "Zstandard"),
            (with(2, UNDIVIDED | 7 << 5), "codec is 7"),
            (with(2, BITS_SHUFFLED), "shuffles bits"),
            (with(2, STORED), "needs 2048 bytes"),
            (with(3, 0), "0 and 1024 bytes"),
            (with(4, 1), "2049"),
            (with(9, 0), "at least one byte"),
            (with(19, 1), "needs 4 bytes"),
            (with(24, 255), "a Blosc frame of an OpenVDB grid needs"),
            (with(28, 255), "LZ4"),
        ] {
            let error = unpacked(&frame, 2048).map(|_| cause).unwrap_err();
            assert!(error.to_string().contains(cause), "{cause}: {error}");
        }
        for length in 0..good.len() {
            assert!(unpacked(&good[..length], 2048).is_err(), "{length}");
        }
        crate::load::damage::survives(&good, |damaged| drop(unpacked(damaged, 2048)));
    }
}
