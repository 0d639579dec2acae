"""The viewer, native or in a browser, and pictures from it: viewer, web, address, pages, pictures, printed."""
