//! Films as animated PNG files.

use crate::failure::Failure;
use crate::parse::Size;

/// Frames per second.
const RATE: u16 = 12;

/// An animated PNG file that goes on forever; each frame has three bytes per pixel.
pub(super) fn apng(size: Size, frames: &[Vec<u8>]) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, RATE)?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(frame)?;
    }
    writer.finish()?;
    Ok(file)
}

/// Two pictures of one size side by side.
pub(super) fn beside(width: u32, left: &[u8], right: &[u8]) -> Vec<u8> {
    let row = 3 * width as usize;
    let rows = left.chunks_exact(row).zip(right.chunks_exact(row));
    rows.flat_map(|(left, right)| left.iter().chain(right).copied())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_a_picture_with_as_many_frames() {
        let size = Size {
            width: 4,
            height: 1,
        };
        let frame = |v: u8| beside(2, &[v; 6], &[9, 8, 7, 6, 5, v]);
        let frames: Vec<Vec<u8>> = (0..5).map(frame).collect();
        assert_eq!(frames[1], [1, 1, 1, 1, 1, 1, 9, 8, 7, 6, 5, 1]);
        let file = apng(size, &frames).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 5);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for frame in &frames {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(&pixels, frame);
        }
        // Programs that know no animations show the first frame.
        let still = image::load_from_memory(&file).unwrap().to_rgb8();
        assert_eq!(still.into_raw(), frames[0]);
    }
}
