//! Shadows that can be asked.

use std::sync::Arc;

use gpu_backend::Cpu;

use crate::file;
use crate::file_error::FileError;
use crate::form::Form;
use crate::graph::Graph;
use crate::layout::Layout;
use crate::top::Top;
use crate::{Builder, DepthSource, Error, LightSpace, Resolution};

/// The shadows that the static geometry of a scene casts from one light: for
/// every voxel of a grid in the space of the light, whether it is lit.
///
/// The bytes are those of the file, whoever owns them: a `Vec<u8>` that was
/// just built, a slice, a mapping. They are never copied and may begin at any
/// address.
#[derive(Debug, Clone)]
pub struct ShadowDag<B = Vec<u8>> {
    pub(crate) bytes: B,
    // Shared with what is made of the same shadows for other memory.
    pub(crate) layout: Arc<Layout>,
    pub(crate) top: Arc<Top>,
}

/// Runs an expression with `$nodes` being the nodes in the form that they are
/// stored in, so that queries are compiled once for each form.
macro_rules! with_nodes {
    ($dag:expr, $nodes:ident => $body:expr) => {{
        let layout = &*$dag.layout;
        match &layout.stored {
            crate::layout::Stored::Plain(levels) => {
                let $nodes = &crate::nodes::Plain {
                    bytes: $dag.as_bytes(),
                    masks: layout.masks,
                    mask_count: layout.mask_count,
                    levels,
                };
                $body
            }
            crate::layout::Stored::Packed { shapes, levels } => {
                let $nodes = &crate::nodes::Packed {
                    bytes: $dag.as_bytes(),
                    masks: layout.masks,
                    mask_count: layout.mask_count,
                    shapes: shapes.map(|(start, _)| start),
                    levels,
                };
                $body
            }
        }
    }};
}
pub(crate) use with_nodes;

impl Builder {
    /// Builds the shadows of `casters`, in the plain form.
    ///
    /// Holds the depths of one part of the map per thread, and the nodes. The
    /// result does not depend on the number of threads.
    ///
    /// # Errors
    /// What `casters` returns, and [`Error::TooManyNodes`].
    pub fn build<C: DepthSource + ?Sized>(
        &self,
        cpu: &Cpu,
        casters: &C,
    ) -> Result<ShadowDag, Error> {
        let graph = self.graph(cpu, casters)?;
        ShadowDag::from_graph(&graph, casters.light().as_ref(), Form::Plain)
    }
}

impl ShadowDag {
    pub(crate) fn from_graph(
        graph: &Graph,
        light: Option<&LightSpace>,
        form: Form,
    ) -> Result<Self, Error> {
        let bytes = file::write(graph, light, form)?;
        // Bytes that were just written need no checks but those that find out where everything
        // is.
        Layout::read(&bytes)
            .map(|layout| Self::new(bytes, layout))
            .map_err(|_| Error::TooManyNodes { limit: u32::MAX })
    }

    /// The bytes, which are a complete file.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

impl<B> ShadowDag<B> {
    /// The same shadows in bytes that are known to be a file with this layout.
    pub(crate) fn from_parts(bytes: B, layout: Arc<Layout>, top: Arc<Top>) -> Self {
        Self { bytes, layout, top }
    }

    /// Voxels along each axis.
    pub fn resolution(&self) -> Resolution {
        self.layout.resolution
    }

    /// Where in the grid a point of the world is, if that is known.
    pub fn light(&self) -> Option<&LightSpace> {
        self.layout.light.as_ref()
    }

    /// How the nodes are stored.
    pub fn form(&self) -> Form {
        self.layout.form()
    }
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// Takes the bytes of a file for shadows, where they are. Compressed ones
    /// have to be [read](ShadowDag::read) instead.
    ///
    /// Reads all of them once: afterwards no query can fail, whatever they
    /// are. Memory that is needed beside them is at most a small part of their
    /// length, or 128 kB.
    ///
    /// # Errors
    /// [`FileError`] if they are not a whole and consistent file, and
    /// [`FileError::Compressed`] if they are compressed.
    pub fn from_bytes(bytes: B) -> Result<Self, FileError> {
        let layout = Layout::read(bytes.as_ref())?;
        file::validate(bytes.as_ref(), &layout)?;
        Ok(Self::new(bytes, layout))
    }

    fn new(bytes: B, layout: Layout) -> Self {
        let dag = Self {
            bytes,
            top: Arc::new(Top::root(&layout)),
            layout: Arc::new(layout),
        };
        let log2 = Top::suitable(&dag.layout, dag.as_bytes().len());
        dag.with_top_grid(log2)
    }

    /// Replaces the `log2` coarsest levels by a grid of references of
    /// `2^log2` cells along each axis; 0 to 5, and no more than there are
    /// levels. The default is the largest that is no larger than the nodes.
    #[must_use]
    pub fn with_top_grid(mut self, log2: u32) -> Self {
        let log2 = Top::allowed(&self.layout, log2);
        let top = with_nodes!(self, nodes => Top::new(nodes, &self.layout, log2));
        self.top = Arc::new(top);
        self
    }

    /// The bytes, which are a complete file.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_ref()
    }

    /// The same shadows, in bytes that are borrowed.
    pub fn borrowed(&self) -> ShadowDag<&[u8]> {
        let (layout, top) = (Arc::clone(&self.layout), Arc::clone(&self.top));
        ShadowDag::from_parts(self.as_bytes(), layout, top)
    }

    /// The same shadows in another form.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`] if the plain form of a level is too long for
    /// its references.
    pub fn to_form(&self, form: Form) -> Result<ShadowDag, Error> {
        ShadowDag::from_graph(&self.graph(), self.light(), form)
    }

    pub(crate) fn graph(&self) -> Graph {
        with_nodes!(self, nodes => Graph::collect(self.resolution(), nodes, self.layout.root))
    }
}
