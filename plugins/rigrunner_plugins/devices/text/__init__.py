"""What instruments that talk in text have in common: line ends, numbers, serial lines."""
