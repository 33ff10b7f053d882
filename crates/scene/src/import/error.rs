//! What can be wrong with a file, where, and what to do about it.

use std::io;
use std::path::PathBuf;

/// Why a model could not be imported.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct ImportError {
    /// The model asked for.
    pub file: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: ImportProblem,
}

/// What is wrong with a model. `at` names the element by its place in the JSON, e.g. `nodes[3] "hip"`.
#[derive(Debug, thiserror::Error)]
pub enum ImportProblem {
    /// The model, or a buffer or image it refers to, does not exist.
    #[error("{} does not exist ({wanted_by}); check the path, or copy the file to where the model expects it", path.display())]
    MissingFile {
        /// The file that is not there.
        path: PathBuf,
        /// What asked for it.
        wanted_by: String,
    },
    /// A file exists but cannot be read.
    #[error("{} cannot be read ({wanted_by}): {source}; check that it is a readable file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What asked for it.
        wanted_by: String,
        /// The system's answer.
        source: io::Error,
    },
    /// The binary container is damaged.
    #[error("damaged GLB container: {problem}; export or download the file again")]
    Glb {
        /// What does not fit.
        problem: String,
    },
    /// The JSON does not parse.
    #[error("not valid JSON: {source}; a .gltf must be glTF 2.0 JSON and a .glb must start with \"glTF\"")]
    Json {
        /// Line, column and cause.
        source: serde_json::Error,
    },
    /// The JSON parses but is not glTF 2.0.
    #[error("{at}: {problem}; run a glTF validator on the file and export it again")]
    Schema {
        /// The element.
        at: String,
        /// What is missing or of the wrong type.
        problem: String,
    },
    /// A glTF version other than 2.0 is needed.
    #[error("needs glTF {version}, only 2.0 is supported; convert it to glTF 2.0")]
    Version {
        /// `asset.minVersion`, else `asset.version`.
        version: String,
    },
    /// A required extension is not supported.
    #[error("requires the extension {name}, which is not supported; {remedy}")]
    UnsupportedExtension {
        /// Its name.
        name: String,
        /// How to get a file that works.
        remedy: &'static str,
    },
    /// An index points outside its list.
    #[error("{at}: {list}[{index}] does not exist (there are {count}); correct the index or export the file again")]
    BadIndex {
        /// The element that holds the index.
        at: String,
        /// The list.
        list: String,
        /// The index.
        index: u64,
        /// Length of the list.
        count: usize,
    },
    /// More bytes are asked for than there are.
    #[error(
        "{at}: needs {needed} bytes where {available} are present; the file is truncated or its counts are wrong, export it again"
    )]
    OutOfBounds {
        /// The element.
        at: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes present.
        available: u64,
    },
    /// The import would take more memory than the file can justify.
    #[error(
        "{at}: decoding needs over {limit} bytes, far more than the file holds; its counts are wrong, export it again"
    )]
    TooLarge {
        /// The element that passed the limit.
        at: String,
        /// The limit in bytes.
        limit: u64,
    },
    /// A buffer has neither a URI nor the container's binary chunk.
    #[error(
        "{at}: buffers[{buffer}] holds no data, it may only stand in for compressed data; export the file again with its buffers"
    )]
    MissingBuffer {
        /// The element that reads it.
        at: String,
        /// The buffer.
        buffer: usize,
    },
    /// A compressed buffer view does not decode.
    #[error("{at}: its bytes are no compressed {content}; they are damaged, export or download the file again")]
    Compressed {
        /// The buffer view.
        at: String,
        /// What the bytes should hold: attributes, triangles or indices.
        content: &'static str,
    },
    /// A URI is malformed, or names something that is not a local file.
    #[error("{at}: {problem}; use a relative file name or a base64 data URI")]
    Uri {
        /// The element.
        at: String,
        /// What is wrong.
        problem: String,
    },
    /// An accessor has the wrong type, component type, count or stride for its use.
    #[error("{at}: {problem}; export the file again")]
    Accessor {
        /// The accessor and its use.
        at: String,
        /// What is wrong.
        problem: String,
    },
    /// A NaN or infinity where a finite number is needed.
    #[error(
        "{at}: element {element} is NaN or infinite; repair the mesh or animation in the program that made it and export again"
    )]
    NonFinite {
        /// The accessor and its use.
        at: String,
        /// Index of the first bad element.
        element: usize,
    },
    /// A number outside its legal range.
    #[error("{at}: {problem}; correct the value")]
    Value {
        /// The element.
        at: String,
        /// What is wrong.
        problem: String,
    },
    /// A node is its own ancestor.
    #[error("{at} is its own ancestor: the hierarchy must be a tree; remove it from the `children` of its descendants")]
    Cycle {
        /// A node on the cycle.
        at: String,
    },
    /// A node has two parents, or a scene's root has one.
    #[error("{at} is a child of {first} and of {second}: a node has one parent; duplicate the node")]
    SharedParent {
        /// The node.
        at: String,
        /// One place that lists it.
        first: String,
        /// The other.
        second: String,
    },
    /// An image does not decode.
    #[error("{at}: {problem}; convert the image to PNG or JPEG")]
    Image {
        /// The image.
        at: String,
        /// What the decoder said.
        problem: String,
    },
}
