//! Recordings as files: bytes, channels, drawings, damage, and foreign readers.
//!
//! A test belongs here if it needs the public API of this package only. The test that counts the threads of its process is a
//! binary of its own, `parallel_reading_is_deterministic`.

// A small recording with every kind of message.
#[path = "../shared/sample.rs"]
mod sample;

// Topics, schemas, field names, types and tags never change.
mod channels_are_frozen;
// Fields are read without the Rust type of their message.
mod fields_are_read_by_name;
// Lines of the start are one message.
mod log_lines_are_recorded;
// The same frames give the same bytes, and come back bitwise identical.
mod recording_is_byte_identical;
// Keyframes have the scalars of all frames, and no hash of a drawing.
mod keyframes_hold_all_scalars;
// Drawings at a distance change no other message.
mod frames_are_drawn_at_a_distance;

// Frames read from damaged files are bitwise equal, and the error states the loss.
mod damage_is_reported;
// Chunks of one group that are missing, repeated, in another order or of another group.
mod changed_chunks_are_reported;
// The constants of the particles are recorded when they change, and joined with the state.
mod particles_are_joined_with_the_state;
// Claims of a file are compared with what a recording can have.
mod claims_are_plausible;
// Two recordings are compared without decoding what is equal.
mod equal_chunks_are_not_decoded;
// Frames that wait for the disk take bounded memory.
mod frames_in_memory_are_bounded;
// A recording gets its final name only when it is complete.
mod final_name_marks_complete_recordings;
// Other MCAP readers open a recording.
mod recordings_open_in_other_readers;

// Drawings take little space compared with the state.
mod drawings_are_small;
// Drawings show the state within their grid.
mod drawings_are_to_scale;
// Layouts name only topics and fields that exist.
mod layouts_name_only_existing_channels;
