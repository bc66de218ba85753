"""Teaching the program what markers look like: click on one, and see what is found."""
