"""Contact with the default scheme against references: the tables of doc/verification/contact.md."""
