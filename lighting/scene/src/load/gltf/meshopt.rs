//! The byte streams of `EXT_meshopt_compression` and `KHR_meshopt_compression`.
//!
//! Based on: A. Kapoulkine et al., `KHR_meshopt_compression`, appendices A
//! (bitstream) and B (filters). Streams of version 0 and 1 are read alike,
//! whichever of the two extensions names them. FIFO entries that were never
//! written read as 2³² − 1, which no mesh has as an index.

use crate::load::LoadError;
use crate::load::limits::Budget;

/// Elements of a vertex block are decoded in groups of this many.
const GROUP: usize = 16;

/// How a stream is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

impl Mode {
    pub(super) fn from_name(name: &str) -> Option<Self> {
        match name {
            "ATTRIBUTES" => Some(Self::Attributes),
            "TRIANGLES" => Some(Self::Triangles),
            "INDICES" => Some(Self::Indices),
            _ => None,
        }
    }
}

/// What is done to attributes after they are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    pub(super) fn from_name(name: &str) -> Option<Self> {
        match name {
            "NONE" => Some(Self::None),
            "OCTAHEDRAL" => Some(Self::Octahedral),
            "QUATERNION" => Some(Self::Quaternion),
            "EXPONENTIAL" => Some(Self::Exponential),
            "COLOR" => Some(Self::Color),
            _ => None,
        }
    }
}

/// What a document says about a stream.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub(super) mode: Mode,
    pub(super) filter: Filter,
    /// Elements.
    pub(super) count: u64,
    /// Bytes of an element.
    pub(super) stride: u64,
}

impl Layout {
    /// The elements in `data`, `count` × `stride` bytes.
    pub(super) fn decode(
        &self,
        data: &[u8],
        what: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u8>, LoadError> {
        let Self {
            mode,
            filter,
            count,
            stride,
        } = *self;
        let is_sound = match mode {
            Mode::Attributes => (4..=256).contains(&stride) && stride % 4 == 0,
            Mode::Triangles => (stride == 2 || stride == 4) && count % 3 == 0,
            Mode::Indices => stride == 2 || stride == 4,
        };
        let is_filter_sound = match filter {
            Filter::None => true,
            _ if mode != Mode::Attributes => false,
            Filter::Octahedral | Filter::Color => stride == 4 || stride == 8,
            Filter::Quaternion => stride == 8,
            Filter::Exponential => true,
        };
        if !is_sound || !is_filter_sound {
            return Err(LoadError::bad_value(
                format!("the compression of {what}"),
                format!("{count} elements of {stride} bytes as {mode:?} with {filter:?}"),
                "a stride and a count that go with mode and filter",
            ));
        }
        let damaged = || {
            LoadError::bad_value(
                format!("the compressed data of {what}"),
                "damaged",
                "a stream as meshopt_compression defines it",
            )
        };
        // The least that any stream takes, before memory is set aside for it.
        let least = match mode {
            Mode::Attributes => count.div_ceil(block(stride as usize) as u64) * (stride / 4),
            Mode::Triangles => 17_u64.saturating_add(count / 3),
            Mode::Indices => count.saturating_add(5),
        };
        if least > data.len() as u64 {
            return Err(LoadError::truncated(
                format!("the compressed data of {what}"),
                least,
                data.len(),
            ));
        }
        budget.take(what, count, stride as usize)?;
        let (count, stride) = (count as usize, stride as usize);
        let mut decoded = match mode {
            Mode::Attributes => attributes(data, count, stride).ok_or_else(damaged)?,
            _ => {
                budget.take(what, count as u64, size_of::<u32>())?;
                let indices = match mode {
                    Mode::Triangles => triangles(data, count / 3),
                    _ => indices(data, count),
                };
                let indices = indices.ok_or_else(damaged)?;
                match stride {
                    2 => indices
                        .iter()
                        .flat_map(|i| (*i as u16).to_le_bytes())
                        .collect(),
                    _ => indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
                }
            }
        };
        match (filter, stride) {
            (Filter::None, _) => {}
            (Filter::Octahedral, 4) => each(&mut decoded, |v: [i8; 4]| octahedral(v, 127.0)),
            (Filter::Octahedral, _) => each(&mut decoded, |v: [i16; 4]| octahedral(v, 32767.0)),
            (Filter::Quaternion, _) => each(&mut decoded, quaternion),
            (Filter::Exponential, _) => each(&mut decoded, |[v]: [i32; 1]| [exponential(v)]),
            (Filter::Color, 4) => each(&mut decoded, |v: [u8; 4]| {
                color(v.map(i32::from), v.map(|x| i32::from(x as i8)), 255.0).map(|x| x as u8)
            }),
            (Filter::Color, _) => each(&mut decoded, |v: [u16; 4]| {
                color(v.map(i32::from), v.map(|x| i32::from(x as i16)), 65535.0).map(|x| x as u16)
            }),
        }
        Ok(decoded)
    }
}

/// Elements per vertex block.
fn block(stride: usize) -> usize {
    ((8192 / stride) & !(GROUP - 1)).min(256)
}

/// Bytes from the front of a slice; `None` where there are too few.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|taken| taken[0])
    }

    /// An unsigned LEB128 number of at most five bytes.
    fn varint(&mut self) -> Option<u32> {
        let mut value = 0;
        for place in 0..5 {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << (7 * place);
            if byte < 0x80 {
                break;
            }
        }
        Some(value)
    }
}

/// Mode 0.
fn attributes(data: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let (header, data) = data.split_first()?;
    let version = match header {
        0xa0 => 0,
        0xa1 => 1,
        _ => return None,
    };
    let channels = if version == 0 { 0 } else { stride / 4 };
    let tail = stride + channels;
    let padded = tail.max(if version == 0 { 32 } else { 24 });
    let (body, _) = data.split_at_checked(data.len().checked_sub(padded)?)?;
    let (baseline, channels) = data[data.len() - tail..].split_at(stride);
    let mut last = baseline.to_vec();
    let mut body = Bytes(body);
    let mut decoded = vec![0; count * stride];
    // Deltas of the four bytes of a channel.
    let mut deltas = [[0; 256]; 4];
    for elements in decoded.chunks_mut(block(stride) * stride) {
        let count = elements.len() / stride;
        let controls = body.take(channels.len())?;
        for channel in 0..stride / 4 {
            let control = controls.get(channel);
            for (byte, deltas) in deltas.iter_mut().enumerate() {
                let widths = match control.map(|control| control >> (2 * byte) & 3) {
                    None => [0, 2, 4, 8],
                    Some(0) => [0, 1, 2, 4],
                    Some(1) => [1, 2, 4, 8],
                    Some(2) => {
                        deltas.fill(0);
                        continue;
                    }
                    Some(_) => {
                        deltas[..count].copy_from_slice(body.take(count)?);
                        continue;
                    }
                };
                let groups = count.div_ceil(GROUP);
                let header = body.take(groups.div_ceil(4))?;
                for (number, group) in deltas.chunks_mut(GROUP).take(groups).enumerate() {
                    let width = header[number / 4] >> (2 * (number % 4)) & 3;
                    fill(group, widths[usize::from(width)], &mut body)?;
                }
            }
            let mode = channels.get(channel).copied().unwrap_or(0);
            let column = 4 * channel;
            let last = &mut last[column..column + 4];
            let rows = elements.chunks_exact_mut(stride).enumerate();
            for (row, element) in rows {
                let delta = [0, 1, 2, 3].map(|byte: usize| deltas[byte][row]);
                let next = undo(mode, delta, [last[0], last[1], last[2], last[3]])?;
                element[column..column + 4].copy_from_slice(&next);
                last.copy_from_slice(&next);
            }
        }
    }
    body.0.is_empty().then_some(decoded)
}

/// Sixteen bytes of `width` bits each; those with all bits set follow as whole
/// bytes.
fn fill(group: &mut [u8], width: u8, body: &mut Bytes<'_>) -> Option<()> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(body.take(GROUP)?),
        _ => {
            let packed = body.take(GROUP * usize::from(width) / 8)?;
            let (sentinel, per_byte) = ((1 << width) - 1, 8 / usize::from(width));
            for (place, value) in group.iter_mut().enumerate() {
                let within = (place % per_byte) as u8;
                // Single bits start at the low end, wider ones at the high end.
                let shift = match width {
                    1 => within,
                    _ => 8 - width * (within + 1),
                };
                *value = packed[place / per_byte] >> shift & sentinel;
                if *value == sentinel {
                    *value = body.byte()?;
                }
            }
        }
    }
    Some(())
}

/// The four bytes that follow `last`.
fn undo(mode: u8, delta: [u8; 4], last: [u8; 4]) -> Option<[u8; 4]> {
    match (mode & 0xf, mode >> 4) {
        (0, 0) => {
            let next = |i: usize| {
                let unsigned = (delta[i] >> 1) ^ (delta[i] & 1).wrapping_neg();
                last[i].wrapping_add(unsigned)
            };
            Some([next(0), next(1), next(2), next(3)])
        }
        (1, 0) => {
            let next = |i: usize| {
                let delta = u16::from_le_bytes([delta[i], delta[i + 1]]);
                let last = u16::from_le_bytes([last[i], last[i + 1]]);
                last.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg())
            };
            let ([a, b], [c, d]) = (next(0).to_le_bytes(), next(2).to_le_bytes());
            Some([a, b, c, d])
        }
        (2, rotation) => {
            // The encoder turned the bits to the right by this.
            let delta = u32::from_le_bytes(delta).rotate_right(rotation.into());
            Some((u32::from_le_bytes(last) ^ delta).to_le_bytes())
        }
        _ => None,
    }
}

/// The most recent sixteen of something.
struct Fifo<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(item: T) -> Self {
        Self {
            items: [item; 16],
            next: 0,
        }
    }

    fn push(&mut self, item: T) {
        self.items[self.next % 16] = item;
        self.next = (self.next + 1) % 16;
    }

    /// 0 is the most recent one.
    fn recent(&self, age: u8) -> T {
        self.items[(self.next + 15 - usize::from(age)) % 16]
    }
}

/// Mode 1.
fn triangles(data: &[u8], count: usize) -> Option<Vec<u32>> {
    let (header, data) = data.split_first()?;
    // In version 0 the codes 13 and 14 are entries of the FIFO.
    let recent = match header {
        0xe0 => 15,
        0xe1 => 13,
        _ => return None,
    };
    let (codes, data) = data.split_at_checked(count)?;
    let (data, table) = data.split_last_chunk::<16>()?;
    let mut data = Bytes(data);
    let (mut next, mut last) = (0_u32, 0_u32);
    let mut edges = Fifo::new([u32::MAX; 2]);
    let mut vertices = Fifo::new(u32::MAX);
    let mut indices = Vec::with_capacity(3 * count);
    let fresh = |next: &mut u32| {
        let index = *next;
        *next = next.wrapping_add(1);
        index
    };
    let free = |data: &mut Bytes<'_>, last: &mut u32| {
        let value = data.varint()?;
        *last = last.wrapping_add((value >> 1) ^ (value & 1).wrapping_neg());
        Some(*last)
    };
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            let [a, b] = edges.recent(high);
            let (c, is_new) = if low == 0 {
                (fresh(&mut next), true)
            } else if low < recent {
                (vertices.recent(low), false)
            } else {
                let c = match low {
                    15 => free(&mut data, &mut last)?,
                    14 => last.wrapping_add(1),
                    _ => last.wrapping_sub(1),
                };
                last = c;
                (c, true)
            };
            if is_new {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            indices.extend([a, b, c]);
            continue;
        }
        let pair = match low {
            14 | 15 => data.byte()?,
            _ => table[usize::from(low)],
        };
        let (z, w) = (pair >> 4, pair & 15);
        if low >= 14 && pair == 0 {
            next = 0;
        }
        let mut a = if low == 15 { 0 } else { fresh(&mut next) };
        let from_queue = |code: u8, next: &mut u32| match code {
            0 => fresh(next),
            _ => vertices.recent(code - 1),
        };
        let mut b = from_queue(z, &mut next);
        let mut c = from_queue(w, &mut next);
        // The table holds no 15; if it does, the stream is damaged.
        if low == 15 {
            a = free(&mut data, &mut last)?;
        }
        if z == 15 {
            b = free(&mut data, &mut last)?;
        }
        if w == 15 {
            c = free(&mut data, &mut last)?;
        }
        vertices.push(a);
        for (code, index) in [(z, b), (w, c)] {
            if code == 0 || code == 15 {
                vertices.push(index);
            }
        }
        edges.push([b, a]);
        edges.push([c, b]);
        edges.push([a, c]);
        indices.extend([a, b, c]);
    }
    data.0.is_empty().then_some(indices)
}

/// Mode 2.
fn indices(data: &[u8], count: usize) -> Option<Vec<u32>> {
    let (header, data) = data.split_first()?;
    if !matches!(header, 0xd0 | 0xd1) {
        return None;
    }
    let (data, _) = data.split_last_chunk::<4>()?;
    let mut data = Bytes(data);
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let value = data.varint()?;
        let last = &mut last[(value & 1) as usize];
        let value = value >> 1;
        *last = last.wrapping_add((value >> 1) ^ (value & 1).wrapping_neg());
        indices.push(*last);
    }
    data.0.is_empty().then_some(indices)
}

/// Replaces each `N` numbers by others.
fn each<T: bytemuck::Pod, const N: usize>(bytes: &mut [u8], change: impl Fn([T; N]) -> [T; N])
where
    [T; N]: bytemuck::Pod,
{
    for element in bytes.chunks_exact_mut(size_of::<[T; N]>()) {
        let changed = change(bytemuck::pod_read_unaligned(element));
        element.copy_from_slice(bytemuck::bytes_of(&changed));
    }
}

/// Filter 1. `one` is 1 as a normalised number of the result.
fn octahedral<T: Copy + Into<f32> + FromRounded>([x, y, one_in, w]: [T; 4], one: f32) -> [T; 4] {
    let (mut x, mut y): (f32, f32) = (x.into(), y.into());
    let z = one_in.into() - x.abs() - y.abs();
    let fold = z.min(0.0);
    x += if x >= 0.0 { fold } else { -fold };
    y += if y >= 0.0 { fold } else { -fold };
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { one / length } else { 0.0 };
    [
        T::from_rounded(x * scale),
        T::from_rounded(y * scale),
        T::from_rounded(z * scale),
        w,
    ]
}

/// An integer from the float nearest to it.
trait FromRounded {
    fn from_rounded(value: f32) -> Self;
}

impl FromRounded for i8 {
    fn from_rounded(value: f32) -> Self {
        value.round() as Self
    }
}

impl FromRounded for i16 {
    fn from_rounded(value: f32) -> Self {
        value.round() as Self
    }
}

/// Filter 2.
fn quaternion(input: [i16; 4]) -> [i16; 4] {
    let one = f32::from(input[3] | 3);
    let range = std::f32::consts::FRAC_1_SQRT_2 / one;
    let [x, y, z] = [input[0], input[1], input[2]].map(|value| f32::from(value) * range);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = (input[3] & 3) as usize;
    let mut output = [0; 4];
    for (place, value) in [(1, x), (2, y), (3, z), (0, w)] {
        output[(largest + place) % 4] = (value * 32767.0).round() as i16;
    }
    output
}

/// Filter 3: the bits of an `f32`.
fn exponential(value: i32) -> i32 {
    let (exponent, mantissa) = (value >> 24, value << 8 >> 8);
    // Exact in f64 for any exponent of eight bits.
    let number = f64::from(mantissa) * 2_f64.powi(exponent);
    (number as f32).to_bits() as i32
}

/// Filter 4: the components as unsigned and as signed numbers.
fn color(unsigned: [i32; 4], signed: [i32; 4], one: f32) -> [f32; 4] {
    let [y, _, _, alpha] = unsigned;
    let [_, co, cg, _] = signed;
    // All bits up to the highest one of the alpha.
    let bits = 32 - (alpha as u32).leading_zeros();
    let scale = (1_i32 << bits) - 1;
    let alpha = (alpha << 1) & scale | (alpha & 1);
    let factor = if scale > 0 { one / scale as f32 } else { 0.0 };
    [y + co - cg, y + cg, y - co - cg, alpha].map(|value| (value as f32 * factor).round())
}

#[cfg(test)]
mod tests;
