"""Tools of a laboratory: files made, checked, imported and compared; a rig operated manually."""
