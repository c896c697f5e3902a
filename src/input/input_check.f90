!> What the records say about each other, before anything is meshed.
!!
!! The mesh before it is used: no element is inverted.
module input_check
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower
  use input_draft, only: build_t
  use mesh_body, only: group_named, group_hint
  use patch_spec, only: GEO_MESH, GEO_SPLINE
  use input_contact, only: check_contacts
  use input_lists, only: MAX_NUMBER
  use word_material, only: material_index
  use word_patch, only: patch_named
  use input_rigid, only: check_rigid
  use input_npatch, only: npatch_name
  use input_where, only: where_t, unknown_face, W_FACES, W_EDGE, W_GROUP
  use spline_set, only: check_set
  use mesh, only: mesh_t, is_rigid
  use tensor, only: det3
  implicit none
  private
  public :: check_references, check_jacobians

contains

  !> Names and numbers that records refer to; errors go to the list.
  subroutine check_references(build)
    type(build_t), intent(inout) :: build
    integer :: i, j

    if (build%incomplete) return ! something was skipped: what is missing may have stood there
    call check_patches(build)
    do i = 1, size(build%npatch)
      call check_material(build, build%npatch(i)%material, build%npatch(i)%place)
      call check_words(build, build%npatch(i)%material, .true.)
    end do
    call check_element_materials(build)
    do i = 1, build%nsupport
      call check_where(build, build%support(i)%at)
    end do
    do i = 1, build%nmove
      call check_where(build, build%move(i)%at)
    end do
    do i = 1, build%npress
      call check_where(build, build%press(i)%at)
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        associate (c => build%curve(i)%column(j))
          if (c%at%kind /= 0) call check_where(build, c%at)
          if (allocated(c%body)) call check_name(build, c%body, c%body_place)
        end associate
      end do
    end do
    do i = 1, size(build%contact)
      do j = 1, 2
        call check_where(build, build%contact(i)%at(j))
      end do
    end do
    call check_contacts(build)
    call check_rigid(build)
  end subroutine check_references

  !> Materials and NPATch geometry of the patches.
  subroutine check_patches(build)
    type(build_t), intent(inout) :: build
    type(error_t), allocatable :: error
    integer :: i, j

    do i = 1, size(build%patch)
      associate (p => build%patch(i))
        if (p%spec%type /= 'RIGID') then
          if (p%spec%geometry == GEO_MESH) then
            do j = 1, size(p%mesh%material)
              call check_material(build, p%mesh%material(j)%number, p%mesh%material(j)%place)
              call check_words(build, p%mesh%material(j)%number, .false.)
            end do
            cycle
          end if
          if (.not. allocated(p%material_place%file)) cycle ! its own error is in the list
          call check_material(build, p%material, p%material_place)
          call check_words(build, p%material, .false.)
        end if
        call check_patch_size(build, i)
        if (p%npatch == 0) cycle
        if (p%npatch > size(build%npatch)) then
          call fail(error, DECK_ERROR, 'NPATch '//to_text(p%npatch)//' is not defined', &
                    p%npatch_place, &
                    'the deck has '//to_text(size(build%npatch))//' NPATch solids')
          call build%errors%add(error)
        else
          build%npatch(p%npatch)%is_geometry = .true.
        end if
      end associate
    end do
  end subroutine check_patches

  !> Nothing is meshed that a mesh cannot hold; the other patches are counted at the end.
  subroutine check_patch_size(build, i)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: i
    type(error_t), allocatable :: error
    real(wp) :: n

    associate (spec => build%patch(i)%spec)
      n = product(real(spec%nelem, wp)*merge(2.0_wp, 1.0_wp, spec%type == 'Q2') + 1.0_wp)
      if (n <= MAX_NUMBER) return
      call fail(error, DECK_ERROR, 'patch '//quoted(spec%name)//' has '//to_text(n)//' nodes', &
                spec%place, 'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
    end associate
    call build%errors%add(error)
  end subroutine check_patch_size

  subroutine check_material(build, number, place)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: number
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(:), allocatable :: hint
    integer :: i

    if (material_index(build, number) > 0) return
    hint = 'the deck has no MATErial'
    if (size(build%model%material) > 0) hint = 'defined:'
    do i = 1, min(size(build%model%material), 20)
      hint = hint//' '//to_text(build%model%material(i)%number)
    end do
    call fail(error, DECK_ERROR, 'material '//to_text(number)//' is not defined', place, hint)
    call build%errors%add(error)
  end subroutine check_material

  !> Words of a material that the formulation of a body does not use.
  subroutine check_words(build, number, is_npatch)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: number
    logical, intent(in) :: is_npatch
    type(error_t), allocatable :: error
    integer :: m

    m = material_index(build, number)
    if (m == 0) return
    associate (set => build%model%material(m))
      if (set%given_formulation .and. .not. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has DISPlacement or ENHAnced, but a PATCh uses it', &
                  set%place, 'remove the word: TYPE decides in a PATCh')
      else if (set%enhanced .and. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' is ENHAnced, but an NPATch uses it', &
                  set%place, 'enhanced modes belong to 8-node elements')
      else if (any(set%nurbs_points > 0) .and. .not. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has NURB interp, but a PATCh uses it', &
                  set%place, 'remove the word: QUADrature in the PATCh chooses the points')
      end if
    end associate
    if (.not. allocated(error)) return
    call build%errors%add(error)
    build%model%material(m)%given_formulation = .false. ! said once
    build%model%material(m)%enhanced = .false.
    build%model%material(m)%nurbs_points = 0
  end subroutine check_words

  !> Materials of ELEM and BLOC, each unknown one once.
  subroutine check_element_materials(build)
    type(build_t), intent(inout) :: build
    integer, allocatable :: missing(:)
    integer :: e, last

    allocate (missing(0))
    last = -1
    do e = 1, build%elements%top
      if (build%elements%nen(e) == 0) cycle
      associate (m => build%elements%material(e))
        if (m == last) cycle
        last = m
        if (material_index(build, m) > 0 .or. any(missing == m)) cycle
        missing = [missing, m]
        call check_material(build, m, build%places%at(build%elements%place(e)))
      end associate
    end do
  end subroutine check_element_materials

  subroutine check_where(build, at)
    type(build_t), intent(inout) :: build
    type(where_t), intent(in) :: at

    if (all(at%kind /= [W_FACES, W_EDGE, W_GROUP])) return
    if (is_known(build, at%body)) then
      call check_group(build, at)
    else
      call check_name(build, at%body, at%place)
    end if
  end subroutine check_where

  !> A patch of that name, or an NPATch.
  logical function is_known(build, name) result(known)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    integer :: i

    known = patch_named(build, name) > 0
    do i = 1, size(build%npatch)
      if (npatch_name(i) == name .and. .not. build%npatch(i)%is_geometry) known = .true.
    end do
  end function is_known

  !> Faces of patches are known; a mesh has the groups of its file, and ALL.
  subroutine check_group(build, at)
    type(build_t), intent(inout) :: build
    type(where_t), intent(in) :: at
    type(error_t), allocatable :: error
    integer :: p

    p = patch_named(build, at%body)
    if (p > 0) then
      if (build%patch(p)%spec%geometry == GEO_SPLINE .and. at%kind == W_GROUP) then
        call check_set(build%patch(p)%spec%spline%surface, at%body, at%face, at%face_place, error)
        if (allocated(error)) call build%errors%add(error)
        return
      end if
      if (build%patch(p)%spec%geometry /= GEO_MESH) p = 0
    end if
    if (p == 0) then
      if (at%kind == W_GROUP) call unknown_face(at%face, at%face_place, error)
    else if (lower(at%face) /= 'all') then
      associate (mesh => build%patch(p)%mesh)
        if (any(group_named(mesh%file, at%face))) return
        call fail(error, DECK_ERROR, 'mesh '//quoted(at%body)//' has no group ' &
                  //quoted(at%face), at%face_place, group_hint(mesh%file, at%face))
      end associate
    end if
    if (allocated(error)) call build%errors%add(error)
  end subroutine check_group

  !> A patch of that name, or an NPATch; else what is there.
  subroutine check_name(build, name, place)
    type(build_t), intent(inout) :: build
    character(*), intent(in) :: name
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(len(name) + 64), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: i

    if (is_known(build, name)) return
    allocate (names(size(build%patch) + size(build%npatch)))
    do i = 1, size(build%patch)
      names(i) = build%patch(i)%spec%name
    end do
    do i = 1, size(build%npatch)
      names(size(build%patch) + i) = npatch_name(i)
    end do
    if (size(names) == 0) then
      hint = 'the deck has no PATCh; NODE n, POINt x y z and PLANe direction coordinate need none'
    else
      hint = 'nearest known: '//nearest(name, names)
    end if
    call fail(error, DECK_ERROR, 'patch '//quoted(name)//' is not defined', place, hint)
    call build%errors%add(error)
  end subroutine check_name

  !> Every element must be right-handed at all its integration points; one message a block.
  subroutine check_jacobians(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    type(place_t) :: place
    character(:), allocatable :: text, hint
    real(wp) :: least, worst
    integer :: b, e, first, bad

    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      bad = 0
      first = 0
      worst = 0.0_wp
      do e = 1, mesh%block(b)%nelem
        least = smallest_jacobian(mesh, b, e)
        if (least > 0.0_wp) cycle
        bad = bad + 1
        if (first == 0) then
          first = e
          worst = least
        end if
      end do
      if (bad == 0) cycle
      associate (block => mesh%block(b))
        text = 'element '//to_text(block%number(first))//' is inverted: its Jacobian is ' &
               //to_text(worst)
        if (bad > 1) text = text//', and '//to_text(bad - 1)//' more are'
        hint = 'the first four nodes go counter-clockwise seen from the other four'
        if (block%body > 0) then
          place = mesh%body(block%body)%place
          hint = 'more elements follow the shape more closely; or enrich other faces'
        else
          place = build%places%at(build%elements%place(block%number(first)))
        end if
      end associate
      call fail(error, DECK_ERROR, text, place, hint)
      call build%errors%add(error)
    end do
  end subroutine check_jacobians

  pure real(wp) function smallest_jacobian(mesh, b, e) result(least)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b, e
    real(wp) :: x(3, mesh%block(b)%nen)
    integer :: q

    least = huge(least)
    associate (block => mesh%block(b))
      x = mesh%xr(:, block%conn(:, e))
      associate (basis => block%basis(block%ibasis(e)))
        do q = 1, basis%nq
          least = min(least, det3(matmul(x, transpose(basis%dshp(:, :, q)))))
        end do
      end associate
    end associate
    if (.not. least < huge(least)) least = 0.0_wp
  end function smallest_jacobian

end module input_check
