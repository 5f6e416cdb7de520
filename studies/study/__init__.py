"""Parts shared by all studies: levels, orders, figures of errors, and the class `Study`."""
