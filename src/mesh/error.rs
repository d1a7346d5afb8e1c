//! What can be wrong with the arrays that a cage is made of.

/// Why arrays do not make a cage.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CageError {
    /// A face with fewer than 3 corners.
    #[error("face {face} has {corners} corners; a face needs at least 3")]
    ShortFace {
        /// The face, 0-based.
        face: usize,
        /// Its corners.
        corners: usize,
    },
    /// A corner names a vertex that is not there.
    #[error("face {face} uses vertex {vertex}, but there are {count}")]
    NoSuchVertex {
        /// The face, 0-based.
        face: usize,
        /// The index.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A coordinate is not finite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NotFinite {
        /// The vertex, 0-based.
        vertex: usize,
    },
    /// More corners or vertices than 32-bit indices can name.
    #[error("too many corners or vertices for 32-bit indices")]
    TooLarge,
    /// The number of attribute values does not fit the faces.
    #[error("{what}: {got} given, {wanted} wanted")]
    WrongCount {
        /// Which array.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length it must have.
        wanted: usize,
    },
    /// A crease between vertices that no edge joins.
    #[error("no edge joins vertices {} and {}", vertices[0], vertices[1])]
    NoSuchEdge {
        /// The vertices, 0-based.
        vertices: [u32; 2],
    },
    /// A corner names a vertex that is not there.
    #[error("corner names vertex {vertex}, but there are {count}")]
    NoSuchCorner {
        /// The vertex, 0-based.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A hole names a face that is not there.
    #[error("hole names face {face}, but there are {count}")]
    NoSuchFace {
        /// The face, 0-based.
        face: u32,
        /// How many faces there are.
        count: usize,
    },
    /// A sharpness below 0, or none at all.
    #[error("sharpness {sharpness} of {what}; it must be 0 or more")]
    BadSharpness {
        /// The edge or vertex.
        what: String,
        /// What was given.
        sharpness: f32,
    },
    /// A channel of no numbers, or of too many.
    #[error("channel {name} has {width} numbers per value; 1 to 4 are possible")]
    ChannelWidth {
        /// The channel.
        name: String,
        /// What was given.
        width: usize,
    },
    /// A channel that does not fit the cage.
    #[error("{name}: {got} given, {wanted} wanted")]
    ChannelCount {
        /// The channel.
        name: String,
        /// Its length.
        got: usize,
        /// The length it must have.
        wanted: usize,
    },
    /// A channel with a number that is not finite.
    #[error("{name}: number {index} is not finite")]
    ChannelNotFinite {
        /// The channel.
        name: String,
        /// The number, 0-based.
        index: usize,
    },
    /// An index of a value that is not there.
    #[error("{name}: corner {at} names value {index}, but there are {count}")]
    NoSuchValue {
        /// The channel.
        name: String,
        /// Where the index stands, 0-based.
        at: usize,
        /// The index.
        index: u32,
        /// How many values there are.
        count: usize,
    },
    /// Two channels of one kind and name.
    #[error("two channels are called {name}")]
    SameName {
        /// The name.
        name: String,
    },
}
