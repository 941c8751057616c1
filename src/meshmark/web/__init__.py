"""What is shown in a browser; a wheel of its own, `meshmark-web`."""
