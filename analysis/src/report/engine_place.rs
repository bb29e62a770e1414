//! Where a page has its engine.

/// Where the engine of a page is: the module as gzip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EnginePlace {
    /// Nowhere, because the program does not carry it.
    #[default]
    NotCarried,
    /// Nowhere, because the user wants it so.
    LeftOut,
    /// In a file next to the page.
    NextToPage(&'static [u8]),
    /// In the page.
    InPage(&'static [u8]),
}

impl EnginePlace {
    /// The place that the user has chosen for the module that the program carries, which may be empty.
    pub(crate) fn chosen(module: &'static [u8], no_engine: bool, single_file: bool) -> Self {
        match (no_engine, single_file) {
            _ if module.is_empty() => Self::NotCarried,
            (true, _) => Self::LeftOut,
            (false, true) => Self::InPage(module),
            (false, false) => Self::NextToPage(module),
        }
    }

    /// The module of a page that has one.
    pub(crate) fn module(self) -> Option<&'static [u8]> {
        match self {
            Self::NotCarried | Self::LeftOut => None,
            Self::NextToPage(module) | Self::InPage(module) => Some(module),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn module_is_in_one_place() {
        let module: &'static [u8] = b"module";
        assert_eq!(EnginePlace::chosen(&[], false, true).module(), None);
        assert_eq!(EnginePlace::chosen(module, true, false), EnginePlace::LeftOut);
        assert_eq!(EnginePlace::chosen(module, false, false), EnginePlace::NextToPage(module));
        assert_eq!(EnginePlace::chosen(module, false, true), EnginePlace::InPage(module));
    }
}
