//! Sizes of curves as WGSL, made while compiling: shaders are `'static` text.

/// The sizes of curves of `N` nodes and `C` channels with a capacity of `W N` nodes, or,
/// if `W` is 0, for two more than `N`.
#[derive(Debug)]
pub(crate) struct Sizes<const N: usize, const W: usize, const C: usize>;

/// Digits stand where the numbers go.
const TEMPLATE: &[u8; 196] = b"
const avsm_NODES: u32 = 0x0000u;
const avsm_CAPACITY: u32 = 0x0000u;
const avsm_CHANNELS: u32 = 0x0000u;
const avsm_CHOICE: u32 = 0x0000u;
const avsm_VALUES: u32 = avsm_CAPACITY * avsm_CHANNELS;
";

impl<const N: usize, const W: usize, const C: usize> Sizes<N, W, C> {
    /// The capacity of a curve while it is made, in nodes.
    pub(crate) const CAPACITY: usize = if W == 0 { N + 2 } else { W * N };

    /// From how many nodes the last are chosen: as on the CPU, or as many as a
    /// dispatch can look at (see `build.rs`), or `N`.
    pub(crate) const CHOICE: usize = {
        let mut choice = if W > 1 { (W - 1) * N } else { N };
        while choice > N
            && (1 + C) * choice * choice * choice / 6 + N * choice * choice / 2 > 40_000
        {
            choice -= 1;
        }
        choice
    };

    const BYTES: [u8; TEMPLATE.len()] = {
        assert!(
            C >= 1 && C <= 16 && Self::CAPACITY <= super::LARGEST_CAPACITY,
            "shaders have 1 to 16 channels and a capacity of at most 66 nodes"
        );
        let mut bytes = *TEMPLATE;
        let numbers = [N, Self::CAPACITY, C, Self::CHOICE];
        // The digits of the number of this index end here.
        let (mut index, mut at) = (0, 0);
        while index < numbers.len() {
            while !(bytes[at] == b'0' && bytes[at + 1] == b'u') {
                at += 1;
            }
            let mut digit = 0;
            while digit < 4 {
                bytes[at - digit] = b"0123456789abcdef"[numbers[index] >> (4 * digit) & 15];
                digit += 1;
            }
            (index, at) = (index + 1, at + 2);
        }
        bytes
    };

    /// `avsm_NODES`, `avsm_CAPACITY`, `avsm_CHANNELS`, `avsm_CHOICE`, `avsm_VALUES`.
    pub(crate) const WGSL: &'static str = match std::str::from_utf8(&Self::BYTES) {
        Ok(text) => text,
        Err(_) => panic!("digits are ASCII"),
    };
}
