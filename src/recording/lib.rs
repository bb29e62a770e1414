//! Recordings: one MCAP file per run, its contents, its writer and its reader.
//!
//! Invariant: the package depends on no model; a model declares its columns and messages.

pub mod background;
mod channel;
mod channel_field;
pub mod channels;
pub mod checkpoint;
pub mod drawing;
pub mod error;
pub mod fields;
pub mod file;
pub mod frame;
pub mod keyframe;
pub mod layout;
pub mod merged;
pub mod merged_layout;
pub mod observer;
pub mod paired_frames;
pub mod plot_list;
pub mod provenance;
pub mod reader;
pub mod recorder;
pub mod removal;
pub mod requested_panels;
pub mod scenery;
pub mod storage;

mod block_writer;
mod color;
mod column;
mod container;
mod container_writer;
mod data_section;
mod descriptor;
mod disc_cylinders;
mod disc_drawing;
mod encoded_messages;
mod force_lines;
mod frames;
mod ghosts;
mod header;
mod limits;
mod log_text;
mod open_chunk;
mod packing;
mod playback;
mod record_bytes;
mod record_kind;
mod recorded_frame;
mod scene;
mod schema;
mod sink;
mod spare_memory;
mod stored_frames;
mod table;
mod trail;
mod unpacking;
