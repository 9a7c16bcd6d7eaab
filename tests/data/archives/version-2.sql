CREATE TABLE archive (
    name TEXT NOT NULL,
    value TEXT NOT NULL,
    PRIMARY KEY (name)
);
INSERT INTO archive
  VALUES('version','2');
CREATE TABLE roots (
    id INTEGER NOT NULL,
    name TEXT NOT NULL,
    path TEXT NOT NULL,
    PRIMARY KEY (id),
    UNIQUE (name)
);
INSERT INTO roots (name, path)
  VALUES('runs','runs');
CREATE TABLE runs (
    id INTEGER NOT NULL,
    root INTEGER NOT NULL,
    path TEXT NOT NULL,
    stamp TEXT NOT NULL,
    missing BOOLEAN NOT NULL,
    problem TEXT NOT NULL,
    run_id TEXT,
    started_utc DATETIME,
    ended_utc DATETIME,
    sealed BOOLEAN,
    outcome TEXT,
    reason TEXT,
    procedure TEXT,
    revision TEXT,
    title TEXT,
    rig TEXT,
    mandrel TEXT,
    specimen TEXT,
    type TEXT,
    lot TEXT,
    operator TEXT,
    approval TEXT,
    imported BOOLEAN,
    replayed BOOLEAN,
    simulated BOOLEAN,
    program TEXT,
    no_load_run TEXT,
    recordings INTEGER,
    measurand TEXT,
    symbol TEXT,
    method TEXT,
    torque_nm DOUBLE,
    u_nm DOUBLE,
    expanded_nm DOUBLE,
    dof DOUBLE,
    raw_peak_nm DOUBLE,
    verdict TEXT,
    rule TEXT,
    limit_text TEXT,
    probability_of_conformity DOUBLE,
    failed_checks INTEGER,
    digest_sha256 TEXT,
    manifest_sha256 TEXT,
    bytes BIGINT,
    PRIMARY KEY (id),
    UNIQUE (root, path),
    FOREIGN KEY(root) REFERENCES roots (id)
);
INSERT INTO runs
  VALUES(1,1,'damaged','310ed00c52f3f06fcb6ce1ce66326967',false,'runs/damaged/run.h5 cannot be read: it is not an HDF5 file, or truncated or damaged (it does not start with the signature of HDF5; restore it from a copy or a backup; ''rigrunner recover --salvage'' saves the intact recordings of a run)','damaged','2026-03-01 12:00:00.000000','2026-03-01 12:00:00.000000',true,'completed','','SSPB-STT-1000','A','Starting torque under 1000 N','simulated','M-01','<script>',NULL,NULL,'Zoë','draft',false,false,false,NULL,'no-load',1,'load-induced starting torque','Td','template_inverse',0.72,0.005,0.01,9e999,3.7,'pass','guard_band_u: words','≤ 0.95 N·m',0.99,2,'a63b2dfedfc9bcedeea3b95b6c9f4c643432893f6417af24ce8d3663cfc360af','c9f35216cc0b57c0e085a23decc4501f93de330ad363989758349d5d686bf29e',34642);
INSERT INTO runs
  VALUES(2,1,'gone','ed1eef5b48bd7dc28a95656324e33d53',true,'','gone','2026-03-01 12:00:00.000000','2026-03-01 12:00:00.000000',true,'completed','','SSPB-STT-1000','A','Starting torque under 1000 N','simulated',NULL,'Pt-1',NULL,NULL,NULL,'draft',false,false,false,NULL,NULL,1,'','',NULL,NULL,NULL,NULL,NULL,NULL,'fail','simple','made',NULL,0,'f8e2fcbb280c4345daafae95a9c3f7680ba819374b127bd1a35c89a5dc074463','2f2c00f58fb22f259491782196a9834b3c83ff2471f828bbd7c5cf4f7fb3d166',33638);
INSERT INTO runs
  VALUES(3,1,'kept','40ba2281bc34dfccdd7e8c0446c60f80',false,'','kept','2026-03-01 12:00:00.000000','2026-03-01 12:00:00.000000',true,'completed','','SSPB-STT-1000','A','Starting torque under 1000 N','simulated','M-01','<script>',NULL,NULL,'Zoë','draft',false,false,false,NULL,'no-load',1,'load-induced starting torque','Td','template_inverse',0.72,0.005,0.01,9e999,3.7,'pass','guard_band_u: words','≤ 0.95 N·m',0.99,2,'26e8c95dfe906adf9cc3793b188f31f6135e689ea25b40676996131f1f5c618c','8c249f7a5b1b9a865111fdf68fa96e1dc129898b37409a0d04e79740212857ba',34637);
CREATE TABLE coordinates (
    run INTEGER NOT NULL,
    number INTEGER NOT NULL,
    name TEXT NOT NULL,
    short TEXT,
    value DOUBLE,
    unit TEXT,
    text TEXT,
    PRIMARY KEY (run, number, name),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO coordinates
  VALUES(2,1,'chamber.temperature','temperature',0.0,'°C','0 °C');
INSERT INTO coordinates
  VALUES(2,2,'chamber.temperature','temperature',100.0,'°C','100 °C');
CREATE TABLE decisions (
    run INTEGER NOT NULL,
    number INTEGER NOT NULL,
    file TEXT,
    in_force BOOLEAN NOT NULL,
    verdict TEXT,
    rule TEXT,
    limit_text TEXT,
    limit_source TEXT,
    probability_of_conformity DOUBLE,
    decided_utc DATETIME,
    reason TEXT,
    "by" TEXT,
    why TEXT,
    PRIMARY KEY (run, number),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO decisions
  VALUES(1,1,'run.h5',true,'pass','guard_band_u: words','≤ 0.95 N·m','a drawing',0.99,'2026-03-01 12:00:00.000000','within the limit',NULL,NULL);
INSERT INTO decisions
  VALUES(2,1,'run.h5',true,'fail','simple','made',NULL,NULL,'2026-03-01 12:00:00.000000','made',NULL,NULL);
INSERT INTO decisions
  VALUES(3,1,'run.h5',true,'pass','guard_band_u: words','≤ 0.95 N·m','a drawing',0.99,'2026-03-01 12:00:00.000000','within the limit',NULL,NULL);
CREATE TABLE figures (
    run INTEGER NOT NULL,
    source TEXT NOT NULL,
    name TEXT NOT NULL,
    value DOUBLE,
    u DOUBLE,
    dof DOUBLE,
    unit TEXT,
    PRIMARY KEY (run, source, name),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO figures
  VALUES(1,'fit polynomial','c0',0.9,0.1,9.0,'N·m');
INSERT INTO figures
  VALUES(1,'template_inverse','inertia',0.00232,1.0e-06,9e999,'kg·m²');
INSERT INTO figures
  VALUES(1,'zero','tester.torque',0.0123,NULL,NULL,'N·m');
INSERT INTO figures
  VALUES(2,'zero','tester.torque',0.0123,NULL,NULL,'N·m');
INSERT INTO figures
  VALUES(3,'fit polynomial','c0',0.9,0.1,9.0,'N·m');
INSERT INTO figures
  VALUES(3,'template_inverse','inertia',0.00232,1.0e-06,9e999,'kg·m²');
INSERT INTO figures
  VALUES(3,'zero','tester.torque',0.0123,NULL,NULL,'N·m');
CREATE TABLE files (
    run INTEGER NOT NULL,
    name TEXT NOT NULL,
    bytes BIGINT NOT NULL,
    modified_ns BIGINT NOT NULL,
    sha256 TEXT NOT NULL,
    PRIMARY KEY (run, name),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO files
  VALUES(1,'run.h5',34642,1795904329908737667,'');
INSERT INTO files
  VALUES(2,'note.txt',5,1795904329422174379,'47a8dea66db04a6f2a18b6e27ef53a56f2122c0733e67f3908f1485fe1d4547f');
INSERT INTO files
  VALUES(2,'run.h5',33633,1795904329396737637,'');
INSERT INTO files
  VALUES(3,'run.h5',34637,1795904330908737727,'');
CREATE TABLE inputs (
    run INTEGER NOT NULL,
    name TEXT NOT NULL,
    value TEXT NOT NULL,
    PRIMARY KEY (run, name),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO inputs
  VALUES(1,'operator','Zoë');
INSERT INTO inputs
  VALUES(1,'specimen','<script>');
INSERT INTO inputs
  VALUES(2,'specimen','Pt-1');
INSERT INTO inputs
  VALUES(3,'operator','Zoë');
INSERT INTO inputs
  VALUES(3,'specimen','<script>');
CREATE TABLE points (
    run INTEGER NOT NULL,
    number INTEGER NOT NULL,
    recording TEXT,
    set_frequency_hz DOUBLE,
    frequency_hz DOUBLE,
    load_n DOUBLE,
    cycles INTEGER,
    raw_peak_nm DOUBLE,
    raw_peak_sd_nm DOUBLE,
    torque_nm DOUBLE,
    u_nm DOUBLE,
    expanded_nm DOUBLE,
    dof DOUBLE,
    PRIMARY KEY (run, number),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO points
  VALUES(1,1,'001',10.0,10.001,1000.5,30,3.0,0.01,0.73,0.005,0.01,9e999);
INSERT INTO points
  VALUES(1,2,'002',20.0,20.002,1000.5,30,4.0,0.01,0.74,0.005,0.01,9e999);
INSERT INTO points
  VALUES(3,1,'001',10.0,10.001,1000.5,30,3.0,0.01,0.73,0.005,0.01,9e999);
INSERT INTO points
  VALUES(3,2,'002',20.0,20.002,1000.5,30,4.0,0.01,0.74,0.005,0.01,9e999);
CREATE TABLE results (
    run INTEGER NOT NULL,
    number INTEGER NOT NULL,
    name TEXT,
    symbol TEXT,
    measurand TEXT,
    place TEXT,
    value DOUBLE,
    u DOUBLE,
    expanded DOUBLE,
    dof DOUBLE,
    unit TEXT,
    readings INTEGER,
    lower DOUBLE,
    upper DOUBLE,
    verdict TEXT,
    si_value DOUBLE,
    si_unit TEXT,
    PRIMARY KEY (run, number),
    FOREIGN KEY(run) REFERENCES runs (id) ON DELETE CASCADE
) WITHOUT ROWID;
INSERT INTO results
  VALUES(2,1,'resistance','R','resistance of the sensor','chamber.temperature = 0 °C',100020.0,5.0,10.0,9e999,'mΩ',5,99883.0,100117.0,'pass',100.02,'Ω');
INSERT INTO results
  VALUES(2,2,'resistance','R','resistance of the sensor','chamber.temperature = 100 °C',138950.0,5.0,10.0,9e999,'mΩ',5,138203.0,138808.0,'fail',138.95,'Ω');
CREATE INDEX runs_by_rig ON runs (rig);
CREATE INDEX runs_by_torque ON runs (torque_nm);
CREATE INDEX runs_by_start ON runs (started_utc);
CREATE INDEX runs_by_run_id ON runs (run_id);
CREATE INDEX runs_by_specimen ON runs (specimen);
CREATE INDEX runs_by_lot ON runs (lot);
CREATE INDEX points_by_frequency ON points (set_frequency_hz, torque_nm);
